#include "fmi/instance.hpp"

#include <algorithm>
#include <cereal/archives/binary.hpp>
#include <cereal/types/common.hpp>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "components/text.hpp"
#include "fmi/refusal.hpp"
#include "fmi/snapshot.hpp"

namespace truenorth::fmi {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

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
            return "Integer or Enumeration";
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

}  // namespace

Instance::Instance(const Fmu& fmu, Kind kind, Journal::Sink sink, bool events, StartValues start_values)
    : fmu_(fmu),
      kind_(kind),
      journal_(std::move(sink), fmu.log, events),
      start_values_(std::move(start_values)),
      component_(fresh_component()),
      stop_time_(never) {
    scalars_.reserve(component_->size() + 1);  // steps allocate nothing
}

std::unique_ptr<Component> Instance::fresh_component() {
    auto component = fmu_.make_component(journal_);
    start_values_.apply(*component);
    return component;
}

// ------------------------------------------------------------------ order of calls

void Instance::require(Phases allowed) const {
    if (std::ranges::find(allowed, phase_) != allowed.end()) {
        return;
    }
    std::string list;
    for (const Phase phase : allowed) {
        list += (list.empty() ? "'" : ", '") + std::string(name_of(phase)) + "'";
    }
    throw Refusal("not allowed in the phase '" + std::string(name_of(phase_)) + "', only in " + list);
}

void Instance::set_up_experiment(double start_time, std::optional<double> stop_time) {
    require({Phase::instantiated});
    require_finite("start time", start_time);
    if (stop_time) {
        require_finite("stop time", *stop_time);
        if (*stop_time < start_time) {
            throw Refusal("stop time = " + text(*stop_time) + ": must be at least the start time, " +
                          text(start_time));
        }
    }
    start_time_ = start_time;
    stop_time_ = stop_time.value_or(never);
    time_ = start_time;
}

void Instance::enter_initialisation() {
    require({Phase::instantiated});
    phase_ = Phase::initialising;
    initialised_ = false;
}

void Instance::exit_initialisation() {
    require({Phase::initialising});
    initialise();
    phase_ = kind_ == Kind::co_simulation ? Phase::stepping : Phase::event;
}

void Instance::initialise() {
    if (initialised_ || phase_ != Phase::initialising) {
        return;
    }
    component_->initialise(start_time_);
    initialised_ = true;
    samples_ = 0;
    inputs_changed_ = false;
}

void Instance::step(double time, double size) {
    require({Phase::stepping});
    require_finite("current communication point", time);
    require_finite("step size", size);
    if (size <= 0.0) {
        throw Refusal("step size = " + text(size) + ": must be greater than 0");
    }
    if (std::abs(time - time_) > tolerance_at(time_)) {
        throw Refusal("the step begins at " + text(time) + " s, but the last one ended at " + text(time_) +
                      " s");
    }
    const double end = time + size;
    if (end > stop_time_ + tolerance_at(stop_time_)) {
        throw Refusal("the step ends at " + text(end) + " s, after the stop time of " + text(stop_time_) +
                      " s");
    }
    advance(time, size);
    time_ = end;
}

void Instance::advance(double time, double size) {
    try {
        component_->step(time, size);
    } catch (const std::invalid_argument&) {  // a step that the component cannot make; nothing has changed
        throw;
    } catch (...) {
        phase_ = Phase::failed;
        throw;
    }
}

void Instance::terminate() {
    require({Phase::stepping, Phase::event, Phase::continuous, Phase::failed});
    phase_ = Phase::terminated;
}

void Instance::reset() {
    component_ = fresh_component();
    phase_ = Phase::instantiated;
    start_time_ = time_ = 0.0;
    stop_time_ = never;
    initialised_ = false;
}

// ------------------------------------------------------------------ model exchange

void Instance::enter_event() {
    require({Phase::continuous});
    phase_ = Phase::event;
}

void Instance::enter_continuous() {
    require({Phase::event});
    phase_ = Phase::continuous;
}

void Instance::set_time(double time) {
    require({Phase::event, Phase::continuous});
    require_finite("time", time);
    const double sampled = start_time_ + static_cast<double>(samples_) * component_->sample_period();
    if (time < sampled - tolerance_at(sampled)) {
        throw Refusal("time = " + text(time) + " s: must not be before the last time event, at " +
                      text(sampled) + " s");
    }
    time_ = time;
}

double Instance::next_event() const {
    return start_time_ + static_cast<double>(samples_ + 1) * component_->sample_period();
}

bool Instance::completed_integrator_step() const {
    require({Phase::continuous});
    return time_ >= next_event() - tolerance_at(time_);
}

void Instance::update_discrete_states() {
    require({Phase::event});
    const double event = next_event();
    if (time_ > event + tolerance_at(event)) {
        throw Refusal("time = " + text(time_) + " s: the time event at " + text(event) +
                      " s was missed; the solver must stop at each time event that this FMU announces");
    }
    if (time_ >= event - tolerance_at(event)) {
        const double period = component_->sample_period();
        advance(event - period, period);
        ++samples_;
    } else if (inputs_changed_) {
        advance(time_, 0.0);
    }
    inputs_changed_ = false;
}

void Instance::require_none(std::size_t count) const {
    require({Phase::initialising, Phase::event, Phase::continuous, Phase::failed, Phase::terminated});
    if (count > 0) {
        throw Refusal("this FMU has no continuous states and no event indicators");
    }
}

// ------------------------------------------------------------------ variables

const Variable* Instance::find_variable(unsigned reference) const {
    static constexpr Variable time{
        .name = "time", .causality = Causality::output, .type = Type::real, .elements = 1};
    return reference == component_->size() ? &time : component_->find(reference);
}

const Variable& Instance::variable(unsigned reference, Type type) const {
    const Variable* variable = find_variable(reference);
    if (variable == nullptr) {
        throw Refusal("there is no variable with the value reference " + std::to_string(reference));
    }
    if (variable->type != type) {
        throw Refusal(std::string(variable->name) + " has the type " + name_of(variable->type) + ", not " +
                      name_of(type));
    }
    return *variable;
}

bool Instance::any_of(std::span<const unsigned> references, Causality causality) const {
    return std::ranges::any_of(
        references, [&](unsigned reference) { return find_variable(reference)->causality == causality; });
}

void Instance::require_readable(std::span<const unsigned> references, Type type) const {
    require({Phase::initialising, Phase::stepping, Phase::event, Phase::continuous, Phase::failed,
             Phase::terminated});
    for (const unsigned reference : references) {
        static_cast<void>(variable(reference, type));
    }
}

void Instance::require_settable(std::span<const unsigned> references, Type type) const {
    require({Phase::instantiated, Phase::initialising, Phase::stepping, Phase::event});
    for (const unsigned reference : references) {
        const Variable& candidate = variable(reference, type);
        if (candidate.causality == Causality::output) {
            throw Refusal(std::string(candidate.name) + " is an output and cannot be set");
        }
        if (candidate.causality == Causality::parameter && running()) {
            throw Refusal(std::string(candidate.name) +
                          " is a fixed parameter and cannot change after initialisation");
        }
    }
}

std::span<const unsigned> Instance::scalars(std::span<const unsigned> variables) {
    scalars_.clear();
    for (const unsigned reference : variables) {
        const Variable* const first = find_variable(reference);
        const unsigned elements = first == nullptr ? 1 : first->elements;
        for (unsigned element = 0; element < elements; ++element) {
            scalars_.push_back(reference + element);
        }
    }
    return scalars_;
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
    std::ostringstream stream;
    cereal::BinaryOutputArchive archive(stream);
    archive(kind_);
    component_->save(stream);
    serialize_progress(archive);
    std::string bytes = pack(fmu_.identity, stream.str());
    if (reused == nullptr) {
        return keep(std::move(bytes));
    }
    *reused = State(std::move(bytes));
    return reused;
}

Kind Instance::kind_of(std::istream& state) {
    Kind kind{};
    cereal::BinaryInputArchive{state}(kind);
    return kind;
}

State* Instance::import_state(std::span<const char> bytes) {
    std::istringstream stream(unpack(fmu_.identity, bytes));
    if (kind_of(stream) != kind_) {
        throw Refusal("the stored state is one of an instance for the other kind of simulation");
    }
    return keep({bytes.begin(), bytes.end()});
}

void Instance::restore(const State* state) {
    std::istringstream stream(unpack(fmu_.identity, find(state)->bytes()));
    static_cast<void>(kind_of(stream));
    auto component = fmu_.make_component(journal_);
    component->load(stream);
    cereal::BinaryInputArchive archive(stream);
    serialize_progress(archive);
    component_ = std::move(component);
}

void Instance::release(const State* state) {
    if (state == nullptr) {
        return;
    }
    std::erase_if(states_, [own = find(state)](const auto& candidate) { return candidate.get() == own; });
}

}  // namespace truenorth::fmi
