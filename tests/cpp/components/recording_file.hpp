// A recording.bin as the declarations of recorded_signals.hpp have it, written word by word.
#pragma once

#include <unistd.h>

#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

namespace truenorth {

// Ten seconds at 10 Hz: sample i, from 1, ends 0.1 i after `begin`, and its increments are i and -i in all
// axes. A fix is valid at each whole second and comes with the next sample; a heading each half second.
struct RecordingFile {
    using Row = std::vector<double>;
    static constexpr int samples = 100;
    static constexpr double period = 0.1;

    double begin = 1000.0;
    double step = period;
    std::vector<Row> imu, gnss, body_velocity, heading_aid, height_aid, truth;
    std::string magic = "TNplay1\n";
    std::string appended;

    RecordingFile() {
        for (int i = 1; i <= samples; ++i) {
            const double up = i;
            imu.push_back({0.0, begin + period * i, up, up, up, -up, -up, -up});
            if (i % 10 == 0 && i < samples) {
                const double n = i / 10;
                gnss.push_back({i + 1.0, 1.0, begin + n, 0.1 * n, 0.2 * n, n, n, n, n, 1, 2, 3, 4, 5, 6});
            }
            if (i % 5 == 0) {
                heading_aid.push_back({static_cast<double>(i), 1.0, begin + period * i, 0.01 * i, 0.02});
            }
        }
    }

    // Time of a sample [s].
    [[nodiscard]] double time(int sample) const { return begin + period * sample; }

    [[nodiscard]] std::string bytes() const {
        std::string body = word(begin) + word(step);
        for (const auto* table : {&imu, &gnss, &body_velocity, &heading_aid, &height_aid, &truth}) {
            body += word(static_cast<std::uint64_t>(table->size()));
            for (const Row& row : *table) {
                for (const double value : row) {
                    body += word(value);
                }
            }
        }
        body += appended;
        std::uint64_t sum = 0;
        std::uint64_t sums = 0;
        for (std::size_t i = 0; i + 8 <= body.size(); i += 8) {
            std::uint64_t value = 0;
            for (int k = 7; k >= 0; --k) {
                value = value << 8U | static_cast<unsigned char>(body[i + static_cast<std::size_t>(k)]);
            }
            sum += value;
            sums += sum;
        }
        return magic + word(sum) + word(sums) + body;
    }

  private:
    static std::string word(std::uint64_t value) {
        std::string bytes;
        for (int k = 0; k < 8; ++k) {
            bytes += static_cast<char>(value >> (8 * k) & 0xffU);
        }
        return bytes;
    }
    static std::string word(double value) { return word(std::bit_cast<std::uint64_t>(value)); }
};

// A folder of resources that is gone with this object.
class ResourceFolder {
  public:
    ResourceFolder()
        : path_(std::filesystem::temp_directory_path() / ("a folder " + std::to_string(getpid()))) {
        std::filesystem::create_directories(path_);
    }
    ResourceFolder(const ResourceFolder&) = delete;
    ResourceFolder(ResourceFolder&&) = delete;
    ResourceFolder& operator=(const ResourceFolder&) = delete;
    ResourceFolder& operator=(ResourceFolder&&) = delete;
    ~ResourceFolder() { std::filesystem::remove_all(path_); }

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

    void put(const std::string& content) const {
        std::ofstream(path_ / "recording.bin", std::ios::binary) << content;
    }

  private:
    std::filesystem::path path_;
};

}  // namespace truenorth
