{% from 'log_categories.jinja' import log_categories %}
// Generated from modelDescription/{{ component.name }}.toml; do not edit.
#include <array>
#include <memory>

#include "components/{{ component.snake_name }}.hpp"
#include "fmi/fmu.hpp"

namespace truenorth::fmi {
namespace {

using C = {{ component.name }};

constexpr std::array<Row<C>, {{ component.scalars | length }}> table{ {
{% for scalar in component.scalars %}
{% set variable = scalar.variable %}
{% set type = {'Real': 'double', 'Boolean': 'bool'}.get(variable.type, 'int') %}
{% set kind = {'Real': 'real', 'Boolean': 'boolean', 'Integer': 'integer'}.get(variable.type, 'enumeration') %}
{% set member = cpp.group(variable) ~ '.' ~ cpp.elements(variable)[scalar.position] %}
    { {"{{ scalar.name }}", Causality::{{ variable.causality }}, Type::{{ kind }}, {{ variable.indices | length if scalar.position == 0 else 0 }}},
     [](C& c) { return address_as<{{ type }}>(c.{{ member }}); }},
{% endfor %}
} };

constexpr LogCategories log_categories{
{% for role, category in log_categories.items() %}
    .{{ role }} = "{{ category.name }}",
{% endfor %}
};

}  // namespace

Fmu this_fmu(const std::filesystem::path& resources) {
    return { {"{{ component.name }}", guid()},
            log_categories,
            maker<C>(table, {{ component.default_experiment.step_size }}, resources)};
}

}  // namespace truenorth::fmi
