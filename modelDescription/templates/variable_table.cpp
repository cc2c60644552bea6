{% from 'log_categories.jinja' import log_categories %}
// Generated from modelDescription/{{ component.name }}.toml; do not edit.
#include <array>
#include <memory>

#include "components/{{ component.snake_name }}.hpp"
#include "fmi/fmu.hpp"

namespace truenorth::fmi {
namespace {

namespace declared = {{ component.snake_name }};
using C = {{ component.name }};

constexpr std::array<Row<C>, {{ component.scalars | length }}> table{ {
{% for scalar in component.scalars %}
{% set variable = scalar.variable %}
{% set type = {'Real': 'double', 'Boolean': 'bool'}.get(variable.type, 'int') %}
{% set member = cpp.group(variable) ~ '.' ~ cpp.elements(variable)[scalar.position] %}
{% set enumerated = variable.type in component.enumeration %}
    { {"{{ scalar.name }}", Causality::{{ variable.causality }}, type_of<{{ type }}>, {{ variable.indices | length if scalar.position == 0 else 1 }}},
     Access<C, {{ type }}>{
         [](const C& c) { return {{ 'static_cast<int>(c.%s)' % member if enumerated else 'c.%s' % member }}; },
{% if variable.causality == 'output' %}
         nullptr} },
{% else %}
         [](C& c, {{ type }} v) { c.{{ member }} = {{ 'static_cast<declared::%s>(v)' % variable.type if enumerated else 'v' }}; }} },
{% endif %}
{% endfor %}
} };

std::unique_ptr<Component> make_component(Log& log) {
    return std::make_unique<TabledComponent<C>>(table, {{ component.default_experiment.step_size }}, log);
}

constexpr LogCategories log_categories{
{% for role, category in log_categories.items() %}
    .{{ role }} = "{{ category.name }}",
{% endfor %}
};

}  // namespace

Fmu this_fmu() { return { {"{{ component.name }}", guid()}, log_categories, make_component}; }

}  // namespace truenorth::fmi
