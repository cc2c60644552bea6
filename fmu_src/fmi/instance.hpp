// One running FMU, whatever the FMI version: order of calls, variables, time, and stored states.
//
// A call that cannot be honoured throws and leaves the instance as it was; only a step that broke down
// half way leaves it in the phase `failed`, from which a stored state or a reset leads back.
//
// In model exchange the component has no continuous states: each sample period ends in a time event, at which
// it makes one step; whoever simulates must stop there. A component with inputs looks at them again whenever
// they are set in event mode, so that the order in which the FMUs are evaluated at one instant does not
// matter.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fmi/component.hpp"
#include "fmi/fmu.hpp"
#include "fmi/journal.hpp"
#include "fmi/start_values.hpp"

namespace truenorth::fmi {

enum class Kind : std::uint8_t { co_simulation, model_exchange };

// `stepping` belongs to co-simulation, `event` and `continuous` to model exchange.
enum class Phase : std::uint8_t {
    instantiated,
    initialising,
    stepping,
    failed,
    terminated,
    event,
    continuous
};

// A stored state. It belongs to the instance that made it.
class State {
  public:
    explicit State(std::string bytes) : bytes_(std::move(bytes)) {}
    [[nodiscard]] std::span<const char> bytes() const { return bytes_; }

  private:
    std::string bytes_;
};

class Instance {
  public:
    Instance(const Fmu& fmu, Kind kind, Journal::Sink sink, bool events, StartValues start_values = {});

    void set_up_experiment(double start_time, std::optional<double> stop_time);
    void enter_initialisation();
    void exit_initialisation();
    void step(double time, double size);
    void terminate();
    void reset();

    // Model exchange.
    void enter_event();
    void enter_continuous();
    void set_time(double time);
    void update_discrete_states();
    // Whether the time event has come.
    [[nodiscard]] bool completed_integrator_step() const;
    [[nodiscard]] double next_event() const;
    // For what concerns continuous states and event indicators: there are none.
    void require_none(std::size_t count) const;

    // T is the variables' type here (double, int, bool), External the one of the FMI version.
    // One value for each reference. All or nothing: values are set only when every one of them may be.
    // The reference after the last scalar is the time.
    template <class T, class External>
    void get(std::span<const unsigned> references, std::span<External> values);
    template <class T, class External>
    void set(std::span<const unsigned> references, std::span<const External> values);

    // References of all scalars of the variables that begin with these references, arrays and scalars; valid
    // until the next call.
    [[nodiscard]] std::span<const unsigned> scalars(std::span<const unsigned> variables);

    // States live until they are released, the instance at most. nullptr is a state that does not exist yet.
    [[nodiscard]] State* save(State* overwritten);
    [[nodiscard]] State* import_state(std::span<const char> bytes);
    void restore(const State* state);
    void release(const State* state);
    [[nodiscard]] std::span<const char> bytes(const State* state) const { return find(state)->bytes(); }

    // Time that the last successful step reached.
    [[nodiscard]] double time() const { return time_; }
    [[nodiscard]] Journal& journal() { return journal_; }

  private:
    using Phases = std::initializer_list<Phase>;

    void require(Phases allowed) const;
    void require_readable(std::span<const unsigned> references, Type type) const;
    void require_settable(std::span<const unsigned> references, Type type) const;
    [[nodiscard]] const Variable* find_variable(unsigned reference) const;
    [[nodiscard]] const Variable& variable(unsigned reference, Type type) const;
    [[nodiscard]] bool any_of(std::span<const unsigned> references, Causality causality) const;
    [[nodiscard]] bool running() const { return phase_ == Phase::stepping || phase_ == Phase::event; }
    [[nodiscard]] std::unique_ptr<Component> fresh_component();
    void initialise();
    void advance(double time, double size);
    [[nodiscard]] State* find(const State* state) const;
    [[nodiscard]] static Kind kind_of(std::istream& state);
    State* keep(std::string bytes);

    template <class Archive>
    void serialize_progress(Archive& archive) {
        archive(phase_, start_time_, stop_time_, time_, initialised_, samples_, inputs_changed_);
    }

    Fmu fmu_;
    Kind kind_;
    Journal journal_;
    StartValues start_values_;
    std::unique_ptr<Component> component_;
    std::vector<std::unique_ptr<State>> states_;
    std::vector<unsigned> scalars_;

    Phase phase_ = Phase::instantiated;
    double start_time_ = 0.0;
    double stop_time_ = 0.0;  // infinity: not defined
    double time_ = 0.0;
    bool initialised_ = false;     // the outputs belong to the parameters and inputs that are set
    std::uint64_t samples_ = 0;    // time events so far
    bool inputs_changed_ = false;  // since the component has looked at them, in model exchange
};

template <class T, class External>
void Instance::get(std::span<const unsigned> references, std::span<External> values) {
    require_readable(references, type_of<T>);
    if (any_of(references, Causality::output)) {
        initialise();
    }
    const unsigned time_reference = component_->size();
    for (std::size_t i = 0; i < references.size(); ++i) {
        T value{};
        if (references[i] == time_reference) {
            value = static_cast<T>(time_);
        } else {
            component_->get(references[i], value);
        }
        values[i] = static_cast<External>(value);
    }
}

template <class T, class External>
void Instance::set(std::span<const unsigned> references, std::span<const External> values) {
    require_settable(references, type_of<T>);
    const auto store = [&] {
        for (std::size_t i = 0; i < references.size(); ++i) {
            component_->set(references[i], static_cast<T>(values[i]));
        }
    };
    if (running() && any_of(references, Causality::tunable)) {
        component_->retune(store);
        return;
    }
    store();
    if (running()) {
        inputs_changed_ = phase_ == Phase::event;
    } else {
        initialised_ = false;
    }
}

}  // namespace truenorth::fmi
