#include "fmi/instance.hpp"

#include <algorithm>
#include <cereal/types/common.hpp>
#include <cmath>
#include <limits>
#include <utility>

#include "contract/text.hpp"
#include "fmi/archive.hpp"
#include "fmi/refusal.hpp"
#include "fmi/snapshot.hpp"

namespace truenorth::fmi {
namespace {

// Of any clock that a simulation may have [s]: 300 years, in which a double still tells microseconds.
constexpr double latest = 1e10;
// A day [s]: longer steps are a mistake of units, and as good as a hang.
constexpr double longest_step = 86400.0;

const char* name_of(Phase phase) {
    switch (phase) {
        case Phase::instantiated:
            return "instantiated";
        case Phase::initialising:
            return "initialisation mode";
        case Phase::stepping:
            return "stepping";
        case Phase::failed:
            return "step failed";
        case Phase::terminated:
            return "terminated";
        case Phase::event:
            return "event mode";
        case Phase::continuous:
            return "continuous-time mode";
    }
    return "unknown";
}

const char* name_of(Type type) {
    switch (type) {
        case Type::real:
            return "Real";
        case Type::integer:
            return "Integer";
        case Type::enumeration:
            return "Enumeration";
        case Type::boolean:
            return "Boolean";
    }
    return "unknown";
}

// Masters add up their steps in floating point.
double tolerance_at(double time) { return 1e-9 + 1e-12 * std::abs(time); }

void require_finite(const char* what, double value) {
    if (!std::isfinite(value)) {
        throw Refusal(std::string(what) + " = " + text(value) + ": must be a finite number");
    }
}

void require_time(const char* what, double value) {
    require_finite(what, value);
    if (std::abs(value) > latest) {
        throw Refusal(std::string(what) + " = " + text(value) + ": must be from " + text(-latest) + " to " +
                      text(latest) + " s");
    }
}

}  // namespace

Instance::Instance(const Fmu& fmu, const Use& use, Journal::Sink sink, bool logging, StartValues start_values)
    : fmu_(fmu),
      use_(use),
      journal_(std::move(sink), fmu.log, logging,
               use.fmi_version < 3 ? Journal::Off::events : Journal::Off::all),
      start_values_(std::move(start_values)) {
    begin();
}

void Instance::begin() {
    adopt(fmu_.make_component(journal_));
    start_values_.apply(component_->cells());
}

void Instance::adopt(std::unique_ptr<Component> component) {
    component_ = std::move(component);
    cells_.assign(component_->cells().begin(), component_->cells().end());
    cells_.push_back(
        {.variable = {.name = "time", .causality = Causality::output, .type = Type::real, .elements = 1},
         .address = &progress_.time});
}

// ------------------------------------------------------------------ order of calls

void Instance::refuse_phase(Phases allowed) const {
    std::string list;
    for (const Phase phase : allowed) {
        list += (list.empty() ? "'" : ", '") + std::string(name_of(phase)) + "'";
    }
    throw Refusal("not allowed in the phase '" + std::string(name_of(progress_.phase)) + "', only in " +
                  list);
}

void Instance::set_up_experiment(double start_time, std::optional<double> stop_time) {
    require({Phase::instantiated});
    require_time("start time", start_time);
    if (stop_time) {
        require_finite("stop time", *stop_time);
        if (*stop_time < start_time) {
            throw Refusal("stop time = " + text(*stop_time) + ": must be at least the start time, " +
                          text(start_time));
        }
    }
    progress_.start_time = start_time;
    progress_.stop_time = stop_time.value_or(std::numeric_limits<double>::infinity());
    progress_.time = start_time;
}

void Instance::enter_initialisation() {
    require({Phase::instantiated});
    progress_.phase = Phase::initialising;
    progress_.initialised = false;
}

void Instance::exit_initialisation() {
    require({Phase::initialising});
    initialise();
    progress_.phase = use_.kind == Kind::co_simulation ? Phase::stepping : Phase::event;
}

void Instance::initialise() {
    if (progress_.initialised || progress_.phase != Phase::initialising) {
        return;
    }
    component_->initialise(progress_.start_time);
    progress_.initialised = true;
    progress_.samples = 0;
    progress_.inputs_changed = false;
}

void Instance::step(double time, double size) {
    require({Phase::stepping});
    require_time("current communication point", time);
    require_finite("step size", size);
    if (size <= 0.0) {
        throw Refusal("step size = " + text(size) + ": must be greater than 0");
    }
    if (size > longest_step) {
        throw Refusal("step size = " + text(size) + ": must be at most " + text(longest_step) + " s");
    }
    if (std::abs(time - progress_.time) > tolerance_at(progress_.time)) {
        throw Refusal("the step begins at " + text(time) + " s, but the last one ended at " +
                      text(progress_.time) + " s");
    }
    const double end = time + size;
    if (end > progress_.stop_time + tolerance_at(progress_.stop_time)) {
        throw Refusal("the step ends at " + text(end) + " s, after the stop time of " +
                      text(progress_.stop_time) + " s");
    }
    advance(time, size);
    progress_.time = end;
}

void Instance::advance(double time, double size) {
    try {
        component_->step(time, size);
    } catch (const std::invalid_argument&) {  // a step that the component cannot make; nothing has changed
        throw;
    } catch (...) {
        progress_.phase = Phase::failed;
        throw;
    }
}

void Instance::terminate() {
    require({Phase::stepping, Phase::event, Phase::continuous, Phase::failed});
    progress_.phase = Phase::terminated;
}

void Instance::reset() {
    begin();
    progress_ = {};
}

// ------------------------------------------------------------------ model exchange

void Instance::enter_event() {
    require({Phase::continuous});
    progress_.phase = Phase::event;
}

void Instance::enter_continuous() {
    require({Phase::event});
    progress_.phase = Phase::continuous;
}

void Instance::set_time(double time) {
    require({Phase::event, Phase::continuous});
    require_time("time", time);
    const double sampled =
        progress_.start_time + static_cast<double>(progress_.samples) * component_->sample_period();
    if (time < sampled - tolerance_at(sampled)) {
        throw Refusal("time = " + text(time) + " s: must not be before the last time event, at " +
                      text(sampled) + " s");
    }
    progress_.time = time;
}

double Instance::next_event() const {
    return progress_.start_time + static_cast<double>(progress_.samples + 1) * component_->sample_period();
}

bool Instance::completed_integrator_step() const {
    require({Phase::continuous});
    return progress_.time >= next_event() - tolerance_at(progress_.time);
}

void Instance::update_discrete_states() {
    require({Phase::event});
    const double event = next_event();
    if (progress_.time > event + tolerance_at(event)) {
        throw Refusal("time = " + text(progress_.time) + " s: the time event at " + text(event) +
                      " s was missed; the solver must stop at each time event that this FMU announces");
    }
    if (progress_.time >= event - tolerance_at(event)) {
        const double period = component_->sample_period();
        advance(event - period, period);
        ++progress_.samples;
    } else if (progress_.inputs_changed) {
        advance(progress_.time, 0.0);
    }
    progress_.inputs_changed = false;
}

void Instance::require_none(std::size_t count) const {
    require({Phase::initialising, Phase::event, Phase::continuous, Phase::failed, Phase::terminated});
    if (count > 0) {
        throw Refusal("this FMU has no continuous states and no event indicators");
    }
}

// ------------------------------------------------------------------ variables

void Instance::refuse_values(std::span<const unsigned> references, Reach reach, Type type,
                             std::size_t count) const {
    std::size_t needed = 0;
    for (const unsigned reference : references) {
        if (reference >= cells_.size()) {
            throw Refusal("there is no variable with the value reference " + std::to_string(reference));
        }
        const Cell& cell = cells_[reference];
        if (reach == Reach::variable && cell.variable.elements == 0) {
            throw Refusal("the value reference " + std::to_string(reference) +
                          " is that of no variable, but of " + cell.variable.name +
                          ", an element of an array");
        }
        if (!fits(cell, reach, type)) {
            throw Refusal(std::string(cell.variable.name) + " has the type " + name_of(cell.variable.type) +
                          ", not " + name_of(type));
        }
        needed += extent(cell, reach);
    }
    throw Refusal("nValues = " + std::to_string(count) + ": the variables have " + std::to_string(needed) +
                  " elements");
}

void Instance::refuse_to_set(std::span<const unsigned> references, Causalities refused) const {
    const auto first = std::ranges::find_if(references, [&](unsigned reference) {
        return (bit(cells_[reference].variable.causality) & refused) != 0;
    });
    const Variable& variable = cells_[*first].variable;
    throw Refusal(std::string(variable.name) +
                  (variable.causality == Causality::output
                       ? " is an output and cannot be set"
                       : " is a fixed parameter and cannot change after initialisation"));
}

// ------------------------------------------------------------------ states

State* Instance::keep(std::string bytes) {
    states_.push_back(std::make_unique<State>(std::move(bytes)));
    return states_.back().get();
}

State* Instance::find(const State* state) const {
    const auto found = std::ranges::find_if(states_, [&](const auto& own) { return own.get() == state; });
    if (found == states_.end()) {
        throw Refusal(
            "this is no state that the instance has stored; to hand a state over to another instance, "
            "serialise it");
    }
    return found->get();
}

State* Instance::save(State* overwritten) {
    State* const reused = overwritten == nullptr ? nullptr : find(overwritten);
    std::string payload;
    StateWriter archive(payload);
    archive(progress_);
    component_->save(archive);
    std::string bytes = pack(fmu_.identity, use_, payload);
    if (reused == nullptr) {
        return keep(std::move(bytes));
    }
    *reused = State(std::move(bytes));
    return reused;
}

State* Instance::import_state(std::span<const char> bytes) {
    static_cast<void>(unpack(fmu_.identity, use_, bytes));
    return keep({bytes.begin(), bytes.end()});
}

void Instance::require_possible(const Progress& progress) const {
    const bool in_its_kind = use_.kind == Kind::co_simulation
                                 ? progress.phase <= Phase::terminated
                                 : progress.phase <= Phase::continuous && progress.phase != Phase::stepping;
    const bool in_time = std::abs(progress.start_time) <= latest && std::abs(progress.time) <= 2.0 * latest &&
                         progress.stop_time >= progress.start_time;
    if (!in_its_kind || !in_time) {
        throw Refusal("the stored state is damaged: its phase or its times are impossible");
    }
}

void Instance::restore(const State* state) {
    StateReader archive(unpack(fmu_.identity, use_, find(state)->bytes()));
    Progress progress;
    archive(progress);
    require_possible(progress);
    auto component = fmu_.make_component(journal_);
    component->load(archive);
    archive.finish();
    if (progress.initialised || progress.phase > Phase::initialising) {
        component->retune([] {});  // refuses parameters that no initialisation has accepted
    }
    adopt(std::move(component));
    progress_ = progress;
}

void Instance::release(const State* state) {
    if (state == nullptr) {
        return;
    }
    std::erase_if(states_, [own = find(state)](const auto& candidate) { return candidate.get() == own; });
}

}  // namespace truenorth::fmi
