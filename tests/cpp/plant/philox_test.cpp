#include "plant/philox.hpp"

#include <gtest/gtest.h>

namespace truenorth::plant {
namespace {

// Random123 1.14 (Salmon et al. 2011), tests/kat_vectors, philox4x32 10.
TEST(Philox, KnownAnswersOfRandom123) {
    constexpr std::uint32_t ones = 0xFFFFFFFFU;
    EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (PhiloxCounter{0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8}));
    EXPECT_EQ(philox({ones, ones, ones, ones}, {ones, ones}),
              (PhiloxCounter{0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD}));
}

// C++26, [rand.predef]: the 10000th number of a default-constructed philox4x32 (seed 20111115) is 1955073260.
// Four numbers a block: it is the last one of block 2499.
TEST(Philox, KnownAnswerOfTheStandardLibrary) {
    EXPECT_EQ(philox({2499, 0, 0, 0}, {20111115, 0})[3], 1955073260U);
}

}  // namespace
}  // namespace truenorth::plant
