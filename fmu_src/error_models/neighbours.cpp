#include "error_models/neighbours.hpp"

namespace truenorth {

namespace {

using Row = Eigen::Array<double, 1, Neighbours::kLanes>;
using Vectors = Components<Row>;

// Quaternions, of the vector part v.
struct Turn {
    Row w;
    Vectors v;
};

template <class A, class B>
Vectors cross(const A& a, const B& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// As quaternion() of attitude.hpp.
Turn turn(const Vectors& rotation_vector) {
    const auto& [x, y, z] = rotation_vector;
    const Row angle2 = x * x + y * y + z * z;
    Row sine_over_angle = 0.5 - angle2 / 48.0;
    Row cosine = 1.0 - angle2 / 8.0;
    if (angle2.maxCoeff() > 1e-8) {
        const Row angle = angle2.sqrt();
        const SineCosine<Row> half = sincos(Row(0.5 * angle));
        sine_over_angle = (angle2 > 1e-8).select(half.sine / angle, sine_over_angle);
        cosine = (angle2 > 1e-8).select(half.cosine, cosine);
    }
    return {.w = cosine, .v = {sine_over_angle * x, sine_over_angle * y, sine_over_angle * z}};
}

// a turned back by q.
Vectors turned_back(const Turn& q, const Eigen::Vector3d& a) {
    const Vectors half = cross(a, q.v);
    const Vectors across = cross(half, q.v);
    const auto along = [&](int i) -> Row { return a[i] + 2.0 * (q.w * half[i] + across[i]); };
    return {along(0), along(1), along(2)};
}

}  // namespace

Neighbours::Neighbours(const NavigationState& state, const Mechanisation& mechanisation,
                       const ImuIncrement& increment)
    : dt_(increment.dt),
      start_(state),
      end_([&] {
          Mechanisation moved = mechanisation;
          moved.state = state;
          moved.advance(increment);
          return moved.state;
      }()),
      gained_(0.5 * increment.dt * mechanisation.acceleration()),
      delta_velocity_(state.q_bn * mechanisation.motion(increment).delta_velocity),
      place_at_start_(start_.position),
      place_at_end_(end_.position),
      centre_(carried(Deviations::Zero()).col(0)) {}

Neighbours::Lanes Neighbours::carried(const Deviations& deviations) const {
    using Place = earth::PlaceOf<Row>;
    using namespace navigation_error;
    const auto component = [&](int i) -> Row { return deviations.row(i); };

    // Small as they are, changes are kept apart from what they change, whose last bit they would lose.
    const Row north = component(kPosition + 1) * place_at_start_.per_meridian_radius;
    const Row latitude = start_.position.latitude + north;
    const Row height = start_.position.height + component(kPosition + 2);
    const auto at_start = [&](int i) -> Row { return start_.velocity[i] + component(kVelocity + i); };
    const Vectors velocity{at_start(0), at_start(1), at_start(2)};
    const Turn phi = turn({component(kPhi), component(kPhi + 1), component(kPhi + 2)});

    // At the middle of the interval.
    const Vectors velocity_mid{velocity[0] + gained_[0], velocity[1] + gained_[1], velocity[2] + gained_[2]};
    const double half = 0.5 * dt_;
    const Place place_before(latitude, height);
    const Place place(Row(latitude + half * velocity[1] * place_before.per_meridian_radius),
                      Row(height + half * velocity[2]));
    const Vectors omega_en = place.transport_rate(velocity_mid);
    const Row omega_ie_n = earth::kRate * place.cos_latitude;
    const Row omega_ie_u = earth::kRate * place.sin_latitude;
    const Vectors rotation{dt_ * omega_en[0], dt_ * (omega_ie_n + omega_en[1]),
                           dt_ * (omega_ie_u + omega_en[2])};

    const Vectors force = turned_back(phi, delta_velocity_);
    const Vectors turning = cross(rotation, force);
    const Vectors coriolis = cross(
        Vectors{omega_en[0], 2.0 * omega_ie_n + omega_en[1], 2.0 * omega_ie_u + omega_en[2]}, velocity_mid);
    const auto gain = [&](int i) -> Row { return force[i] - 0.5 * turning[i] - dt_ * coriolis[i]; };
    const Vectors change{gain(0), gain(1), gain(2) - dt_ * place.gravity()};
    const auto mean = [&](int i) -> Row { return velocity[i] + 0.5 * change[i]; };
    const Vectors position_rate = place.position_rate(Vectors{mean(0), mean(1), mean(2)});

    const Turn n = turn(rotation);
    const Vectors across = cross(phi.v, n.v);
    Lanes end;
    end.row(kTurn) = phi.w * n.w - (phi.v[0] * n.v[0] + phi.v[1] * n.v[1] + phi.v[2] * n.v[2]);
    for (int i = 0; i < 3; ++i) {
        end.row(kTurn + 1 + i) = phi.w * n.v[i] + n.w * phi.v[i] + across[i];
        end.row(kGained + i) = component(kVelocity + i) + change[i];
    }
    end.row(kLatitude) = north + dt_ * position_rate[0];
    end.row(kLongitude) = component(kPosition) *
                              (place_at_start_.per_prime_vertical_radius * place_at_start_.per_cos_latitude) +
                          dt_ * position_rate[1];
    end.row(kHeight) = component(kPosition + 2) + dt_ * position_rate[2];
    return end;
}

Neighbours::Deviations Neighbours::moved(const Deviations& deviations) const {
    using namespace navigation_error;
    const Lanes end = carried(deviations);
    const Eigen::Quaterniond back(centre_[kTurn], -centre_[kTurn + 1], -centre_[kTurn + 2],
                                  -centre_[kTurn + 3]);
    Deviations result;
    for (int i = 0; i < kLanes; ++i) {
        const Eigen::Quaterniond turned(end(kTurn, i), end(kTurn + 1, i), end(kTurn + 2, i),
                                        end(kTurn + 3, i));
        result.col(i).segment<3>(kPhi) = rotation_vector(back * turned);
    }
    const auto off = [&](int row) { return end.row(row) - centre_[row]; };
    for (int i = 0; i < 3; ++i) {
        result.row(kVelocity + i) = off(kGained + i);
    }
    result.row(kPosition) =
        off(kLongitude) / place_at_end_.per_prime_vertical_radius * place_at_end_.cos_latitude;
    result.row(kPosition + 1) = off(kLatitude) / place_at_end_.per_meridian_radius;
    result.row(kPosition + 2) = off(kHeight);
    return result;
}

}  // namespace truenorth
