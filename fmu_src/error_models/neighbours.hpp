// Navigation states beside another one, which are mechanised together with it, a lane each.
//
// A neighbour is given by its deviation (navigation_error.hpp). What its step shares with that of the state,
// the motion of the body and the memory of the mechanisation, is computed once; what depends on where it is
// and how it moves, the rates of n, gravity and the radii, for each: the equations of
// Mechanisation::advance. In the attitude the rotation of the body falls out,
//
//     exp(phi_end x) = exp(-w x) exp(phi x) exp(w_i x)
//
// with w and w_i what n turns by over the increment, at the state and at the neighbour.
#pragma once

#include "error_models/navigation_error.hpp"

namespace truenorth {

class Neighbours {
  public:
    static constexpr int kLanes = 4;
    using Deviations = Points<navigation_error::kCount, kLanes>;

    // Of `state`, over an increment that the mechanisation has not seen yet; its own state does not matter.
    Neighbours(const NavigationState& state, const Mechanisation& mechanisation,
               const ImuIncrement& increment);

    // The state at the end of the increment.
    [[nodiscard]] const NavigationState& moved() const { return end_; }

    // The deviations from it there.
    [[nodiscard]] Deviations moved(const Deviations& deviations) const;

  private:
    // A row each: turn of the attitude (w, x, y, z), velocity, latitude, longitude and height, all from those
    // of the state at the start.
    enum Carried { kTurn = 0, kGained = 4, kLatitude = 7, kLongitude = 8, kHeight = 9, kRows = 10 };
    using Lanes = Eigen::Array<double, kRows, kLanes, Eigen::RowMajor>;

    [[nodiscard]] Lanes carried(const Deviations& deviations) const;

    double dt_;
    NavigationState start_;
    NavigationState end_;
    Eigen::Vector3d gained_;          // in half the increment, of velocity [m/s]
    Eigen::Vector3d delta_velocity_;  // integral of the specific force, in n at the start [m/s]
    earth::Place place_at_start_;
    earth::Place place_at_end_;
    Eigen::Array<double, kRows, 1> centre_;  // of the state itself, a neighbour without deviation
};

}  // namespace truenorth
