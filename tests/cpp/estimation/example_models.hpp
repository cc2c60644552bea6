// Two models to try predictors on: a linear one, and one that is curved in every state.
#pragma once

#include <cmath>

#include "estimation/model.hpp"

namespace truenorth {

// What a model needs beside x -> f(x) on vectors, with H = (I 0).
template <class Derived, int N>
struct VectorModel {
    static constexpr int kStates = N;
    static constexpr int kMeasurements = 2;
    using State = Vector<N>;
    struct Interval {};
    struct Fix {
        Eigen::Vector2d value;
    };

    Matrix<N> Q = Matrix<N>::Zero();

    [[nodiscard]] static State retract(const State& x, const State& d) { return x + d; }

    template <int Count>
    void propagate(State& x, Points<N, Count>& deviations, const Interval& /*interval*/) const {
        const auto& self = static_cast<const Derived&>(*this);
        const State start = x;
        x = self.moved(State(start + deviations.col(0)));
        for (int i = 0; i < Count; ++i) deviations.col(i) = self.moved(State(start + deviations.col(i))) - x;
    }
    [[nodiscard]] Matrix<N> process_noise(const State& /*x*/, const Interval& /*interval*/) const {
        return Q;
    }
    [[nodiscard]] static Eigen::Vector2d residual(const State& x, const Fix& fix) {
        return fix.value - x.template head<2>();
    }
    [[nodiscard]] static Matrix<2, N> measurement_matrix(const State& /*x*/, const Fix& /*fix*/) {
        return Matrix<2, N>::Identity();
    }
    [[nodiscard]] static Eigen::Matrix2d measurement_noise(const State& /*x*/, const Fix& /*fix*/) {
        return Eigen::Vector2d(0.04, 0.09).asDiagonal();
    }
};

template <int N>
struct LinearModel : VectorModel<LinearModel<N>, N> {
    Matrix<N> F = Matrix<N>::Identity();

    [[nodiscard]] Vector<N> moved(const Vector<N>& x) const { return F * x; }
    [[nodiscard]] Matrix<N> transition(const Vector<N>& /*x*/,
                                       const typename LinearModel::Interval& /*i*/) const {
        return F;
    }
};

struct CurvedModel : VectorModel<CurvedModel, 3> {
    template <class V>
    [[nodiscard]] static V map(const V& x) {
        using std::cos;
        using std::sin;
        V y;
        y << x(0) + sin(x(1)), x(1) * cos(x(2)) + x(0) * x(0) / 2, x(2) + x(0) * x(1) * x(2) / 4;
        return y;
    }
    [[nodiscard]] static Vector<3> moved(const Vector<3>& x) { return map(x); }
    [[nodiscard]] static Matrix<3> transition(const Vector<3>& x, const Interval& /*interval*/) {
        Matrix<3> F;
        F << 1.0, std::cos(x(1)), 0.0,                     //
            x(0), std::cos(x(2)), -x(1) * std::sin(x(2)),  //
            x(1) * x(2) / 4.0, x(0) * x(2) / 4.0, 1.0 + x(0) * x(1) / 4.0;
        return F;
    }
};

}  // namespace truenorth
