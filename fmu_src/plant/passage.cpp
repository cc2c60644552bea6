#include "plant/passage.hpp"

#include "inertial/attitude.hpp"

namespace truenorth::plant {

namespace {

Eigen::Vector3d if_known(const Eigen::Vector3d& rate, const Eigen::Vector3d& otherwise) {
    return rate.allFinite() ? rate : otherwise;
}

// Rotation vector from one attitude to another, in the axes of the first.
Eigen::Vector3d turn(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
    return rotation_vector(from.conjugate() * to);
}

}  // namespace

Passage::Passage(const KnownPoint& point) : from_(point) {
    velocity_.linear = if_known(point.acceleration, Eigen::Vector3d::Zero());
    rotation_.linear = if_known(point.body_rate, Eigen::Vector3d::Zero());
}

Passage::Passage(const std::optional<KnownPoint>& before, const KnownPoint& from, const KnownPoint& to)
    : from_(from) {
    const double duration = to.time - from.time;
    // Derivatives at both ends of what changes by `change` now, and has changed by `-back` since the point
    // before.
    const auto estimated = [&](const Eigen::Vector3d& change, const Eigen::Vector3d& back) -> Rates {
        const Eigen::Vector3d slope = change / duration;
        if (!before) {
            return {.begin = slope, .end = slope};
        }
        const double since = from.time - before->time;
        const Eigen::Vector3d curvature = (slope + back / since) / (since + duration);
        return {.begin = slope - duration * curvature, .end = slope + duration * curvature};
    };
    const KnownPoint& earlier = before ? *before : from;

    const Eigen::Vector3d gained = to.velocity - from.velocity;
    Rates rates = estimated(gained, earlier.velocity - from.velocity);
    velocity_ = through(
        gained, duration,
        {.begin = if_known(from.acceleration, rates.begin), .end = if_known(to.acceleration, rates.end)});

    const Eigen::Vector3d turned = turn(from.q_bn, to.q_bn);
    rates = estimated(turned, turn(from.q_bn, earlier.q_bn));
    const Eigen::Vector3d end_rate = left_jacobian(-turned).inverse() * to.body_rate;
    rotation_ =
        through(turned, duration,
                {.begin = if_known(from.body_rate, rates.begin), .end = if_known(end_rate, rates.end)});
}

Kinematics Passage::at(double time) const {
    const double x = time - from_.time;
    const Eigen::Vector3d rotation = rotation_.value(x);
    return {
        .velocity = from_.velocity + velocity_.value(x),
        .acceleration = velocity_.rate(x),
        .C_bn = (from_.q_bn * quaternion(rotation)).toRotationMatrix(),
        .omega_nb_b = left_jacobian(-rotation) * rotation_.rate(x),
    };
}

Eigen::Vector3d Passage::Cubic::value(double x) const { return x * (linear + x * (quadratic + x * cubic)); }

Eigen::Vector3d Passage::Cubic::rate(double x) const {
    return linear + x * (2.0 * quadratic + 3.0 * x * cubic);
}

Passage::Cubic Passage::through(const Eigen::Vector3d& end, double duration, const Rates& rates) {
    const Eigen::Vector3d slope = end / duration;
    return {
        .linear = rates.begin,
        .quadratic = (3.0 * slope - 2.0 * rates.begin - rates.end) / duration,
        .cubic = (rates.begin + rates.end - 2.0 * slope) / (duration * duration),
    };
}

}  // namespace truenorth::plant
