// What can go wrong with an inertial measurement unit, with its clock and on the way of its outputs to
// whoever reads them; one fault at a time. Faults of the increments act IMU sample by IMU sample, whatever
// the step; those of count, time and order act on the outputs, each of which may cover several samples.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "plant/time_window.hpp"

namespace truenorth::plant {

struct ImuOutput {
    std::int64_t count = 0;                                    // of outputs
    double time = 0.0;                                         // end of what the increments cover [s]
    Eigen::Vector3d delta_angle = Eigen::Vector3d::Zero();     // [rad]
    Eigen::Vector3d delta_velocity = Eigen::Vector3d::Zero();  // [m/s]

    template <class Archive>
    void serialize(Archive& archive) {
        archive(count, time, delta_angle, delta_velocity);
    }
};

class ImuFault {
  public:
    enum class Kind {
        none,
        silence,
        not_a_number,
        spike,
        stuck,
        zeros,
        bias_step,
        scale_step,
        count_jump,
        clock_step,
        clock_drift,
        repeated,
        reordered,
    };

    struct Settings {
        Kind kind = Kind::none;
        double begin = 0.0;     // [s]
        double duration = 0.0;  // [s]; 0: once, or for ever
        double size = 0.0;      // in SI units of the kind
        int axis = 0;           // 0: all; 1 to 3: gyro, 4 to 6: accelerometer; right, forward, up
    };

    // Of the gyros, then of the accelerometers.
    using Axes = Eigen::Array<double, 6, 1>;

    struct State {
        bool happened = false;       // what happens once has happened
        Axes before = Axes::Zero();  // increments of the last sample before the fault
        std::int64_t ahead = 0;      // of the count
        bool repeating = false;      // the last output was the one before once more
        bool holding = false;        // `held` has not been put out
        bool overtaken = false;      // the output after it has
        ImuOutput held;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(happened, before, ahead, repeating, holding, overtaken, held);
        }
    };

    // `period`: of the IMU samples [s].
    ImuFault(const Settings& settings, double period);

    // What becomes of the increments of the sample that ends at `time`.
    void distort(State& state, double time, Eigen::Vector3d& delta_angle,
                 Eigen::Vector3d& delta_velocity) const;

    // What is put out when `fresh` is ready; none: what stands there stays.
    [[nodiscard]] std::optional<ImuOutput> put_out(State& state, ImuOutput fresh) const;

    // What the IMU's clock shows at `time`.
    [[nodiscard]] double clock(double time) const;

    // What the fault adds to the biases in the sample that ends at `time` [rad/s, m/s2].
    [[nodiscard]] Axes bias(double time) const;

  private:
    // Whether the fault is on at `time`; one that happens once is so for the first time that asks.
    [[nodiscard]] bool acts(State& state, double time) const;

    [[nodiscard]] std::optional<ImuOutput> reorder(State& state, const ImuOutput& fresh) const;

    Settings settings_;
    double period_;
    TimeWindow window_;
    bool once_;
    Axes concerned_;  // 1 for the increments of the axis, 0 for others
};

}  // namespace truenorth::plant
