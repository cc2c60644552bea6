// The signals of a recording as they lie in the resources of an FMU, in the order in which they are played.
//
// recording.bin is little-endian words of 8 bytes; sim_scenarios/exchange/signals.py writes it:
//
//     8 bytes    "TNplay1\n"
//     2 u64      sum of all words that follow, and sum of the sums up to each of them, modulo 2^64
//     f64        begin: where the interval of the first sample begins, by the recording's clock [s]
//     f64        step: a communication step in which never more than one sample comes, where there is one [s]
//     6 tables   ImuSample, Fix, BodyVelocity, HeadingAid, HeightAid, Truth: a u64, the number of rows, and
//                the rows, each so many f64 as the struct below has, in its order
//
// Times are those of the recording's clock. A measurement of an aid comes with the IMU sample of the number
// `shown`, the first being 1; `count` is how many came with that sample, of which it is the last. Of the
// truth there is a row for the begin and one for each sample, or none at all; what nobody tells is not a
// number.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace truenorth {

namespace recorded {

inline constexpr const char* file_name = "recording.bin";

using Triple = std::array<double, 3>;

struct ImuSample {
    double missed;  // samples that were lost before it
    double time;    // end of the interval [s]
    Triple delta_angle;
    Triple delta_velocity;
};

struct Fix {
    double shown;
    double count;
    double time;
    double latitude;
    double longitude;
    double height;
    Triple velocity;
    Triple position_sigma;
    Triple velocity_sigma;
};

struct BodyVelocity {
    double shown;
    double count;
    double time;
    Triple velocity;
    Triple sigma;
};

struct HeadingAid {
    double shown;
    double count;
    double time;
    double heading;
    double sigma;
};

struct HeightAid {
    double shown;
    double count;
    double time;
    double height;
    double sigma;
};

struct Truth {
    double roll;
    double pitch;
    double heading;
    double latitude;
    double longitude;
    double height;
    Triple velocity;
};

// What tells one recording from another.
struct Sums {
    std::uint64_t words = 0;
    std::uint64_t sums = 0;

    [[nodiscard]] bool operator==(const Sums&) const = default;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(words, sums);
    }
};

}  // namespace recorded

class RecordedSignals {
  public:
    // Reads recording.bin of a folder. Throws std::runtime_error with the file and what is wrong with it.
    explicit RecordedSignals(const std::filesystem::path& resources);

    [[nodiscard]] const recorded::Sums& sums() const { return sums_; }
    [[nodiscard]] double begin() const { return begin_; }
    [[nodiscard]] double step() const { return step_; }
    [[nodiscard]] const std::vector<recorded::ImuSample>& imu() const { return imu_; }
    [[nodiscard]] const std::vector<recorded::Fix>& gnss() const { return gnss_; }
    [[nodiscard]] const std::vector<recorded::BodyVelocity>& body_velocity() const { return body_velocity_; }
    [[nodiscard]] const std::vector<recorded::HeadingAid>& heading_aid() const { return heading_aid_; }
    [[nodiscard]] const std::vector<recorded::HeightAid>& height_aid() const { return height_aid_; }
    [[nodiscard]] const std::vector<recorded::Truth>& truth() const { return truth_; }

  private:
    void check() const;

    recorded::Sums sums_;
    double begin_ = 0.0;
    double step_ = 0.0;
    std::vector<recorded::ImuSample> imu_;
    std::vector<recorded::Fix> gnss_;
    std::vector<recorded::BodyVelocity> body_velocity_;
    std::vector<recorded::HeadingAid> heading_aid_;
    std::vector<recorded::HeightAid> height_aid_;
    std::vector<recorded::Truth> truth_;
};

}  // namespace truenorth
