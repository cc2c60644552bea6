{% import "members.jinja" as members %}
// Generated from modelDescription/{{ component.name }}.toml; do not edit.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cereal/types/array.hpp>
#include <cereal/types/common.hpp>
{% if component.of('input') | selectattr('optional') | list %}
#include <limits>
{% endif %}

#include "contract/parameter_rules.hpp"
#include "contract/serialisation.hpp"
{% for header in component.shared %}
#include "{{ header }}"
{% endfor %}

namespace truenorth::{{ component.snake_name }} {

{{ members.enumerations(component.own_enumerations) -}}
{% for name in component.shared_enumerations %}
using settings::{{ name }};
{% endfor %}

{% for title, of_struct in [
    ('Parameters', parameters),
    ('Inputs', nest(component.of('input'))),
    ('Outputs', nest(component.of('output')))] %}
struct {{ title }} {
{{ members.body(of_struct, '    ', cpp) -}}
};

{% endfor %}
{% macro rules(variables, struct) %}
{% for variable in variables %}
{% set elements = cpp.elements(variable) %}
{% for name in variable.scalar_names %}
{% set value = struct ~ '.' ~ elements[loop.index0] %}
{% if variable.type == 'Real' %}
    rules::finite("{{ name }}", {{ value }});
{% endif %}
{% for rule, limit in [('at_least', variable.smallest), ('greater_than', variable.above), ('at_most', variable.largest)] if limit is not none %}
    rules::{{ rule }}("{{ name }}", {{ value }}, {{ cpp.limit(variable, limit) }});
{% endfor %}
{% if variable.type == 'Real' and variable.above == 0 %}
    rules::invertible("{{ name }}", {{ value }});
{% endif %}
{% if variable.type in component.enumeration %}
    rules::one_of("{{ name }}", {{ value }}, { {%- for item in component.enumeration[variable.type].items %}"{{ item.name }}"{{ ', ' if not loop.last }}{% endfor -%} });
{% endif %}
{% endfor %}
{% endfor %}
{% endmacro %}
// Throws InvalidParameter for the first parameter that breaks a rule of its declaration.
inline void validate(const Parameters& parameters) {
{{ rules(component.of('parameter', 'tunable'), 'parameters') -}}
}
{% set read_at_start = component.of('input') | selectattr('at_start') | rejectattr('optional') | list %}
{% if read_at_start %}

// The same for inputs that are read at the start.
inline void validate(const Inputs& inputs) {
{{ rules(read_at_start, 'inputs') -}}
}
{% endif %}

// All of the above under one name, for templates that serve several components.
struct Interface {
    using Parameters = {{ component.snake_name }}::Parameters;
    using Inputs = {{ component.snake_name }}::Inputs;
    using Outputs = {{ component.snake_name }}::Outputs;
{% for name in component.enumeration %}
    using {{ name }} = {{ component.snake_name }}::{{ name }};
{% endfor %}
    static void validate(const Parameters& parameters) { {{ component.snake_name }}::validate(parameters); }
};

}  // namespace truenorth::{{ component.snake_name }}
