#include "components/recorded_signals.hpp"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "contract/text.hpp"

namespace truenorth {

namespace {

static_assert(std::endian::native == std::endian::little, "the file is read as it lies");

constexpr std::string_view magic = "TNplay1\n";
constexpr std::size_t word = 8;
constexpr double most = std::numeric_limits<int>::max();  // that a count reaches

std::vector<std::byte> content(const std::filesystem::path& path) {
    // Without a folder it would be whatever lies where the tool runs.
    std::ifstream file(path.has_parent_path() ? path : std::filesystem::path(),
                       std::ios::binary | std::ios::ate);
    const std::streamoff size = file ? static_cast<std::streamoff>(file.tellg()) : -1;
    if (size < 0) {
        throw std::runtime_error(
            "there is no " + path.string() +
            ": `truenorth export RECORDING` makes an FMU that has its recording, and the tool must tell the "
            "FMU where its resources are");
    }
    std::vector<std::byte> bytes(static_cast<std::size_t>(size));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(bytes.data()), size);  // NOLINT(*-reinterpret-cast): bytes as they lie
    if (!file) {
        throw std::runtime_error(path.string() + " cannot be read");
    }
    return bytes;
}

// Takes one value after the other.
class Reader {
  public:
    explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}

    template <class T>
    T take() {
        T value{};
        take_to(&value, 1);
        return value;
    }

    template <class Row>
    void take(std::vector<Row>& rows) {
        static_assert(sizeof(Row) % word == 0);
        const auto count = take<std::uint64_t>();
        if (count > left_.size() / sizeof(Row)) {
            throw std::runtime_error("it is truncated");
        }
        rows.resize(count);
        take_to(rows.data(), rows.size());
    }

    [[nodiscard]] std::span<const std::byte> left() const { return left_; }

  private:
    template <class T>
    void take_to(T* values, std::size_t count) {
        static_assert(std::is_trivially_copyable_v<T>);
        const std::size_t size = count * sizeof(T);
        if (size > left_.size()) {
            throw std::runtime_error("it is truncated");
        }
        if (size > 0) {
            std::memcpy(values, left_.data(), size);
        }
        left_ = left_.subspan(size);
    }

    std::span<const std::byte> left_;
};

recorded::Sums sums_of(std::span<const std::byte> bytes) {
    recorded::Sums found;
    for (Reader words(bytes); !words.left().empty();) {
        found.words += words.take<std::uint64_t>();
        found.sums += found.words;
    }
    return found;
}

// Of a table whose rows come with IMU samples, in their order.
template <class Row>
void check_shown(const char* table, const std::vector<Row>& rows, std::size_t samples) {
    double next = 1.0;
    double count = 0.0;
    for (const Row& row : rows) {
        if (!(row.shown >= next && row.shown <= static_cast<double>(samples)) || !std::isfinite(row.time)) {
            throw std::runtime_error(text(table, " of ", row.time, " s comes with the IMU sample ", row.shown,
                                          ": must be one from ", next, " to ", samples));
        }
        next = row.shown + 1.0;
        count += row.count;
        if (!(row.count >= 1.0 && count <= most)) {
            throw std::runtime_error(text(table, " of ", row.time, " s is the last of ", row.count,
                                          ": must be at least 1, and not more than 32 bits count"));
        }
    }
}

}  // namespace

RecordedSignals::RecordedSignals(const std::filesystem::path& resources) {
    const std::filesystem::path path = resources / recorded::file_name;
    const std::vector<std::byte> bytes = content(path);
    try {
        Reader reader(bytes);
        const auto begins = reader.take<std::array<char, magic.size()>>();
        if (std::string_view(begins.data(), begins.size()) != magic) {
            throw std::runtime_error("it is no recording of this version of the FMU");
        }
        sums_.words = reader.take<std::uint64_t>();
        sums_.sums = reader.take<std::uint64_t>();
        if (reader.left().size() % word != 0 || sums_of(reader.left()) != sums_) {
            throw std::runtime_error("it is truncated or damaged");
        }
        begin_ = reader.take<double>();
        step_ = reader.take<double>();
        reader.take(imu_);
        reader.take(gnss_);
        reader.take(body_velocity_);
        reader.take(heading_aid_);
        reader.take(height_aid_);
        reader.take(truth_);
        if (!reader.left().empty()) {
            throw std::runtime_error(text(reader.left().size()) + " bytes follow its end");
        }
        check();
    } catch (const std::runtime_error& reason) {
        throw std::runtime_error(path.string() + ": " + reason.what());
    }
}

void RecordedSignals::check() const {
    if (!std::isfinite(begin_) || !(step_ > 0.0) || !std::isfinite(step_)) {
        throw std::runtime_error(text("begin = ", begin_, " s, step = ", step_,
                                      " s: must be finite, and the step greater than 0"));
    }
    if (imu_.empty()) {
        throw std::runtime_error("it has no IMU samples");
    }
    double last = begin_;
    double count = 0.0;
    for (const recorded::ImuSample& sample : imu_) {
        if (!(sample.time > last) || !std::isfinite(sample.time)) {
            throw std::runtime_error(text("IMU sample at ", sample.time, " s: must come after ", last, " s"));
        }
        count += 1.0 + sample.missed;
        if (!(sample.missed >= 0.0) || count > most) {
            throw std::runtime_error(
                text("before the IMU sample at ", sample.time, " s ", sample.missed,
                     " were missed: must be at least 0, and not more than 32 bits count"));
        }
        last = sample.time;
    }
    check_shown("fix", gnss_, imu_.size());
    check_shown("velocity in body axes", body_velocity_, imu_.size());
    check_shown("heading", heading_aid_, imu_.size());
    check_shown("height", height_aid_, imu_.size());
    if (!truth_.empty() && truth_.size() != imu_.size() + 1) {
        throw std::runtime_error(text("it has ", truth_.size(), " rows of the truth: must be ",
                                      imu_.size() + 1, ", one for the begin and one for each IMU sample"));
    }
}

}  // namespace truenorth
