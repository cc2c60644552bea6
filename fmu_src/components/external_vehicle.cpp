#include "components/external_vehicle.hpp"

#include <algorithm>
#include <cmath>

#include "contract/text.hpp"
#include "contract/time_tolerance.hpp"
#include "inertial/attitude.hpp"

namespace truenorth {

namespace {

using plant::KnownPoint;
using Flaw = ExternalVehicle::Flaw;
using Found = std::optional<Flaw>;

// The path that shows in a position of double precision, whatever the place [m].
constexpr double kVisible = 1e-6;
// The turn that shows in an attitude of double precision [rad].
constexpr double kTurned = 1e-12;
// What positions may be off beside what velocities say [m].
constexpr double kPositionSlack = 1.0;

bool within(const Flaw& flaw) { return flaw.value >= flaw.least && flaw.value <= flaw.most; }

Found beyond(const Flaw& flaw) { return within(flaw) ? Found() : flaw; }

Found size_beyond(std::string_view name, const Eigen::Vector3d& vector, double most) {
    for (Eigen::Index i = 0; i < 3; ++i) {
        const Flaw flaw{.name = name, .element = i + 1, .value = vector[i], .least = -most, .most = most};
        if (!within(flaw)) {
            return flaw;
        }
    }
    return {};
}

// A derivative that is not given is no flaw.
Found rate_beyond(std::string_view name, const Eigen::Vector3d& rate, double most) {
    return rate.hasNaN() ? Found() : size_beyond(name, rate, most);
}

Found impossible(const ExternalVehicle::State& state) {
    using V = ExternalVehicle;
    constexpr std::string_view position = "external.position";
    constexpr std::string_view attitude = "external.attitude";
    const auto symmetric = [](std::string_view name, Eigen::Index element, double value, double most) {
        return beyond({.name = name, .element = element, .value = value, .least = -most, .most = most});
    };
    Found found = symmetric(position, 1, state.position[0], earth::kHighestLatitude);
    const auto otherwise = [&found](const Found& next) { found = found ? found : next; };
    otherwise(symmetric(position, 2, state.position[1], V::kLargestLongitude));
    otherwise(beyond({.name = position,
                      .element = 3,
                      .value = state.position[2],
                      .least = V::kLowest,
                      .most = V::kHighest}));
    otherwise(size_beyond("external.velocity", state.velocity, V::kLargestSpeed));
    otherwise(symmetric(attitude, 1, state.attitude[0], V::kLargestRoll));
    otherwise(symmetric(attitude, 2, state.attitude[1], V::kLargestPitch));
    otherwise(symmetric(attitude, 3, state.attitude[2], V::kLargestHeading));
    otherwise(rate_beyond("external.acceleration", state.acceleration, V::kLargestAcceleration));
    otherwise(rate_beyond("external.body_rate", state.body_rate, V::kLargestRate));
    return found;
}

KnownPoint point_of(const ExternalVehicle::State& state, double time) {
    const EulerAngles attitude{
        .roll = state.attitude[0], .pitch = state.attitude[1], .heading = state.attitude[2]};
    return {
        .time = time,
        .position = {.latitude = state.position[0],
                     .longitude = state.position[1],
                     .height = state.position[2]},
        .velocity = state.velocity,
        .q_bn = Eigen::Quaterniond(dcm(attitude)),
        .acceleration = state.acceleration,
        .body_rate = state.body_rate,
    };
}

// A vehicle does not leap, and was seen not long ago.
Found leap(const KnownPoint& from, const KnownPoint& to) {
    using V = ExternalVehicle;
    const double duration = to.time - from.time;
    const double speed = std::max(from.velocity.norm(), to.velocity.norm());
    Found found = beyond({.name = "time between two states of external.*",
                          .value = duration,
                          .least = kTimeTolerance,
                          .most = V::kLargestOffset,
                          .reason = "one later than the other, and no longer gap"});
    const auto otherwise = [&found](const Found& next) { found = found ? found : next; };
    otherwise(beyond({.name = "change of external.position",
                      .value = earth::displacement(from.position, to.position).norm(),
                      .most = kPositionSlack + 2.0 * speed * duration,
                      .reason = "1 m and twice the path that external.velocity says"}));
    otherwise(beyond({.name = "change of external.velocity",
                      .value = (to.velocity - from.velocity).norm(),
                      .most = V::kLargestAcceleration * duration,
                      .reason = "1000 m/s2"}));
    otherwise(beyond({.name = "change of external.attitude",
                      .value = angle_between(from.q_bn, to.q_bn),
                      .most = V::kLargestRate * duration,
                      .reason = "100 rad/s"}));
    return found;
}

bool simultaneous(const KnownPoint& a, const KnownPoint& b) {
    return std::abs(a.time - b.time) <= kTimeTolerance;
}

bool equal(const KnownPoint& a, const KnownPoint& b) {
    return a.position.latitude == b.position.latitude && a.position.longitude == b.position.longitude &&
           a.position.height == b.position.height && a.velocity == b.velocity &&
           a.q_bn.coeffs() == b.q_bn.coeffs();
}

// It says that it moves or turns, and is to the bit as it was: a state that is shown once more.
bool held(const KnownPoint& from, const KnownPoint& to) {
    const double elapsed = to.time - from.time;
    const bool moves = to.velocity.norm() * elapsed > kVisible;
    const bool turns = to.body_rate.allFinite() && to.body_rate.norm() * elapsed > kTurned;
    return equal(from, to) && (moves || turns);
}

}  // namespace

std::string ExternalVehicle::Flaw::sentence() const {
    const std::string index = element > 0 ? text("[", element, "]") : "";
    const std::string why = *reason == '\0' ? "" : text(" (", reason, ")");
    // An input as it was set; what was calculated as a person reads it.
    const auto figure = [this](double number) { return text(element > 0 ? number : rounded(number)); };
    return text(name, index.c_str(), " = ", figure(value).c_str(), ": must be from ", figure(least).c_str(),
                " to ", figure(most).c_str(), why.c_str());
}

ExternalVehicle::Verdict ExternalVehicle::read(const State& state, double time, double end) {
    // The first state may be corrected as long as there is no other: by a master that tells it once more.
    const bool again = latest_ && std::abs(time - latest_->time) <= kTimeTolerance;
    if (again && (from_ || equal(*latest_, point_of(state, latest_->time)))) {
        return Verdict::stale;
    }
    const auto refused = [this](const Flaw& flaw) {
        flaw_ = flaw;
        return Verdict::refused;
    };
    const double earliest = latest_ ? latest_->time : end - kLargestOffset;
    if (const Found found = beyond({.name = "external.time",
                                    .value = time,
                                    .least = std::max(earliest, end - kLargestOffset),
                                    .most = end + kLargestOffset,
                                    .reason = "later than the state before, a minute from the step"})) {
        return refused(*found);
    }
    if (const Found found = impossible(state)) {
        return refused(*found);
    }
    const KnownPoint now = point_of(state, time);
    if (!latest_ || again) {
        begin(now);
        return Verdict::begun;
    }
    const bool stamped = !std::isnan(state.time);
    const auto shows = [&](const KnownPoint& point) {
        return stamped ? simultaneous(now, point) : held(point, now);
    };
    if (shows(*latest_) || (doubted_ && shows(*doubted_))) {
        return Verdict::stale;
    }
    const Found found = leap(*latest_, now);
    if (!found) {
        follow(now);
        return Verdict::followed;
    }
    if (doubted_ && !leap(*doubted_, now)) {
        begin(KnownPoint(*doubted_));
        follow(now);
        return Verdict::begun;
    }
    doubted_ = now;
    return refused(*found);
}

plant::Passage ExternalVehicle::passage() const {
    return from_ ? plant::Passage(before_, *from_, to()) : plant::Passage(to());
}

void ExternalVehicle::begin(const KnownPoint& point) {
    before_.reset();
    from_.reset();
    doubted_.reset();
    latest_ = point;
}

void ExternalVehicle::follow(const KnownPoint& point) {
    before_ = from_;
    from_ = latest_;
    latest_ = point;
    doubted_.reset();
}

}  // namespace truenorth
