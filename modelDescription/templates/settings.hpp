{% import "members.jinja" as members %}
// Generated from modelDescription/shared/{{ name }}; do not edit.
#pragma once

namespace truenorth::settings {

{{ members.enumerations(component.enumeration) -}}
{% for group in groups %}
struct {{ group.type_name }} {
{{ members.body(group.members, '    ', cpp) -}}
};

{% endfor %}
}  // namespace truenorth::settings
