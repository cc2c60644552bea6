#include "plant/imu_fault.hpp"

#include <algorithm>
#include <limits>

#include "plant/fault_axes.hpp"

namespace truenorth::plant {

namespace {

// Without a duration such a fault concerns one sample or output.
bool happens_once(ImuFault::Kind kind) {
    using enum ImuFault::Kind;
    return kind == not_a_number || kind == spike || kind == count_jump || kind == repeated ||
           kind == reordered;
}

}  // namespace

ImuFault::ImuFault(const Settings& settings, double period)
    : settings_(settings),
      period_(period),
      window_(TimeWindow::lasting(settings.begin, settings.duration, period)),
      once_(settings.duration == 0.0 && happens_once(settings.kind)),
      concerned_(concerned_by<Axes>(settings.axis)) {}

void ImuFault::distort(State& state, double time, Eigen::Vector3d& delta_angle,
                       Eigen::Vector3d& delta_velocity) const {
    const auto replace = [&](const Axes& other) {
        delta_angle = (concerned_.head<3>() > 0.0).select(other.head<3>(), delta_angle.array());
        delta_velocity = (concerned_.tail<3>() > 0.0).select(other.tail<3>(), delta_velocity.array());
    };
    const auto add = [&](const Axes& more) {
        delta_angle.array() += more.head<3>();
        delta_velocity.array() += more.tail<3>();
    };
    switch (settings_.kind) {
        case Kind::silence:
            if (acts(state, time)) {
                delta_angle.setZero();
                delta_velocity.setZero();
            }
            break;
        case Kind::not_a_number:
            if (acts(state, time)) {
                replace(Axes::Constant(std::numeric_limits<double>::quiet_NaN()));
            }
            break;
        case Kind::spike:
            if (acts(state, time)) {
                add(settings_.size * concerned_);
            }
            break;
        case Kind::stuck:
            if (acts(state, time)) {
                replace(state.before);
            } else {
                state.before << delta_angle, delta_velocity;
            }
            break;
        case Kind::zeros:
            if (acts(state, time)) {
                replace(Axes::Zero());
            }
            break;
        case Kind::bias_step:
            add(bias(time) * period_);
            break;
        case Kind::scale_step:
            if (acts(state, time)) {
                delta_angle.array() *= 1.0 + settings_.size * concerned_.head<3>();
                delta_velocity.array() *= 1.0 + settings_.size * concerned_.tail<3>();
            }
            break;
        default:
            break;
    }
}

std::optional<ImuOutput> ImuFault::put_out(State& state, ImuOutput fresh) const {
    switch (settings_.kind) {
        case Kind::silence:
            if (acts(state, fresh.time)) {
                return std::nullopt;
            }
            break;
        case Kind::count_jump:
            if (acts(state, fresh.time)) {
                state.ahead += static_cast<std::int64_t>(settings_.size);
            }
            fresh.count += state.ahead;
            break;
        case Kind::clock_step:
        case Kind::clock_drift:
            fresh.time = clock(fresh.time);
            break;
        case Kind::repeated:
            state.repeating = acts(state, fresh.time) && !state.repeating;
            if (state.repeating) {
                return std::nullopt;
            }
            break;
        case Kind::reordered:
            return reorder(state, fresh);
        default:
            break;
    }
    return fresh;
}

double ImuFault::clock(double time) const {
    if (settings_.kind == Kind::clock_step && window_.contains(time)) {
        return time + settings_.size;
    }
    if (settings_.kind == Kind::clock_drift) {
        return time + settings_.size * std::clamp(time - settings_.begin, 0.0, window_.end - window_.begin);
    }
    return time;
}

ImuFault::Axes ImuFault::bias(double time) const {
    if (settings_.kind == Kind::bias_step && window_.contains(time)) {
        return settings_.size * concerned_;
    }
    return Axes::Zero();
}

bool ImuFault::acts(State& state, double time) const {
    if (!window_.contains(time) || (once_ && state.happened)) {
        return false;
    }
    state.happened = true;
    return true;
}

std::optional<ImuOutput> ImuFault::reorder(State& state, const ImuOutput& fresh) const {
    if (!state.holding) {
        state.holding = acts(state, fresh.time);
        if (!state.holding) {
            return fresh;
        }
        state.held = fresh;
        return std::nullopt;
    }
    if (!state.overtaken) {
        state.overtaken = true;
        return fresh;
    }
    ImuOutput late =
        state.held;  // in the place of `fresh`, which is held in turn, or lost: the fault is over
    state.holding = acts(state, fresh.time);
    state.overtaken = false;
    state.held = fresh;
    return late;
}

}  // namespace truenorth::plant
