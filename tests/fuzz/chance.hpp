// Arguments by chance, the awkward ones more often than they deserve: equal seeds make equal arguments, and
// so do equal bytes, which a guided fuzzer turns over until they lead somewhere new.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <random>
#include <span>

namespace truenorth::fuzz {

class Chance {
  public:
    explicit Chance(std::uint64_t seed) : engine_(seed) {}

    // Of bytes, which must live as long; zero once they are spent.
    explicit Chance(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    [[nodiscard]] bool spent() const { return bytes_ && bytes_->empty(); }

    // A whole number below `end`.
    std::size_t below(std::size_t end) {
        return static_cast<std::size_t>(draw((std::bit_width(end - 1) + 7U) / 8U) % end);
    }

    bool one_in(std::size_t count) { return below(count) == 0; }

    double uniform(double least, double most) {
        return least + (most - least) * static_cast<double>(draw(sizeof(std::uint64_t)) >> 11U) * 0x1p-53;
    }

    double real() {
        static constexpr std::array awkward{0.0,
                                            -0.0,
                                            1.0,
                                            -1.0,
                                            0.01,
                                            1e-300,
                                            1e9,
                                            -1e10,
                                            1e100,
                                            std::numeric_limits<double>::max(),
                                            std::numeric_limits<double>::lowest(),
                                            std::numeric_limits<double>::infinity(),
                                            std::numeric_limits<double>::quiet_NaN(),
                                            std::numeric_limits<double>::denorm_min()};
        return one_in(2) ? awkward[below(awkward.size())] : uniform(-10.0, 10.0);
    }

    std::int32_t integer() {
        static constexpr std::array awkward{0, 1, -1, std::numeric_limits<std::int32_t>::max(),
                                            std::numeric_limits<std::int32_t>::min()};
        return one_in(2) ? awkward[below(awkward.size())] : static_cast<std::int32_t>(below(8));
    }

    // A reference of the `count` that there are, now and then one that there is not.
    std::uint32_t reference(std::size_t count) {
        return static_cast<std::uint32_t>(one_in(50) ? draw(sizeof(std::uint32_t)) : below(count + 2));
    }

    // The pointer, now and then NULL.
    template <class T>
    T* perhaps(T* pointer) {
        return one_in(40) ? nullptr : pointer;
    }

  private:
    // A number; of bytes, of so many.
    std::uint64_t draw(std::size_t size) {
        if (!bytes_) {
            return engine_();
        }
        std::uint64_t number = 0;
        for (; size > 0 && !bytes_->empty(); --size) {
            number = number << 8U | bytes_->front();
            bytes_ = bytes_->subspan(1);
        }
        return number;
    }

    std::mt19937_64 engine_;
    std::optional<std::span<const std::uint8_t>> bytes_;
};

}  // namespace truenorth::fuzz
