// The angle of a point in the plane, of one or of each of a set, with the same bits on every processor (see
// sincos.hpp). Error below 2.5 ulp; coordinates and their sum are finite and none is subnormal; signs of
// zeros as of std::atan2.
//
// The smaller coordinate over the larger is the tangent of at most pi/4; one beyond tan(pi/8) is turned back,
//
//     atan(a / b) = pi/4 + atan((a - b) / (a + b)).
//
// Of the tangent t that is left, atan t = t + t^3 P(t^2); P is minimax, relative error 2^-59. The angle is
// k pi/4 with atan t added or taken away.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace truenorth {

// Of the point (x, y), counted from x towards y, in [-pi, pi] [rad].
inline double arctangent(double y, double x) {              // NOLINTBEGIN(*-nested-conditional-operator)
    constexpr double tan_of_eighth = 0x1.a827999fcef32p-2;  // pi/8
    constexpr double quarter = 0x1.921fb54442d18p-1;        // pi/4; its products with 1 to 4 are exact
    constexpr double rest_of_quarter = 0x1.1a62633145c07p-55;

    const double abs_x = std::abs(x);
    const double abs_y = std::abs(y);
    const bool exchanged = abs_y > abs_x;
    const bool backwards = std::signbit(x);
    const double smaller = exchanged ? abs_x : abs_y;
    const double larger = exchanged ? abs_y : abs_x;
    const bool turned = smaller > tan_of_eighth * larger;

    const double over = turned ? smaller - larger : smaller;
    const double under = turned ? smaller + larger : larger;
    const double t = over / (under == 0.0 ? 1.0 : under);
    const double z = t * t;
    const double z2 = z * z;
    const double P = (-0x1.555555555553dp-2 + z * 0x1.99999999957bep-3) +
                     z2 * ((-0x1.24924922a9e8ap-3 + z * 0x1.c71c70e4e4c93p-4) +
                           z2 * ((-0x1.745cf8be9d7b9p-4 + z * 0x1.3b11173c46432p-4) +
                                 z2 * ((-0x1.10eba4b9a5142p-4 + z * 0x1.df0e43a4a24ccp-5) +
                                       z2 * ((-0x1.9cce681bcdf8cp-5 + z * 0x1.37cb4d1a1f5f6p-5) +
                                             z2 * -0x1.2554f215b932dp-6))));
    const double angle = t + t * z * P;

    const double sign = exchanged == backwards ? 1.0 : -1.0;
    const double from = exchanged ? 2.0 : (backwards ? 4.0 : 0.0);
    const double quarters = from + (turned ? sign : 0.0);
    return std::copysign((quarters * quarter + sign * angle) + quarters * rest_of_quarter, y);
}  // NOLINTEND(*-nested-conditional-operator)

// Of every pair of elements of two arrays of fixed size.
template <class Y, class X>
typename Y::PlainObject arctangent(const Eigen::ArrayBase<Y>& y, const Eigen::ArrayBase<X>& x) {
    typename Y::PlainObject angles;
    for (Eigen::Index i = 0; i < y.size(); ++i) {
        angles(i) = arctangent(y(i), x(i));
    }
    return angles;
}

}  // namespace truenorth
