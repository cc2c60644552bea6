#include "fmi/snapshot.hpp"

#include <gtest/gtest.h>

#include <string>

#include "fmi/refusal.hpp"

namespace truenorth::fmi {
namespace {

constexpr Identity owner{.name = "Owner", .guid = "{1}"};
constexpr Use co_simulation{.fmi_version = 2, .kind = Kind::co_simulation};

std::string reason_for_refusing(const std::string& bytes, const Identity& reader = owner,
                                const Use& use = co_simulation) {
    try {
        static_cast<void>(unpack(reader, use, bytes));
    } catch (const Refusal& refusal) {
        return refusal.what();
    }
    return "accepted";
}

TEST(Snapshot, GivesBackWhatWasPacked) {
    const std::string payload("\0 any \xff bytes", 12);
    EXPECT_EQ(unpack(owner, co_simulation, pack(owner, co_simulation, payload)), payload);
    EXPECT_EQ(unpack(owner, co_simulation, pack(owner, co_simulation, "")), "");
}

TEST(Snapshot, SaysWhoseStateItIs) {
    const std::string bytes = pack(owner, co_simulation, "payload");
    EXPECT_EQ(reason_for_refusing(bytes, {"Reader", "{1}"}),
              "the stored state is one of Owner; this is Reader");
    EXPECT_EQ(reason_for_refusing(bytes, {"Owner", "{2}"}),
              "the stored state is one of another build of Owner ({1}); this is {2}");
}

TEST(Snapshot, SaysWhatItWasStoredFor) {
    const std::string bytes = pack(owner, co_simulation, "payload");
    EXPECT_EQ(reason_for_refusing(bytes, owner, {.fmi_version = 3, .kind = Kind::co_simulation}),
              "the stored state is one of the FMU for FMI 2; this is the one for FMI 3");
    EXPECT_EQ(reason_for_refusing(bytes, owner, {.fmi_version = 2, .kind = Kind::model_exchange}),
              "the stored state is one of an instance for co-simulation; this is one for model exchange");
}

TEST(Snapshot, EveryChangedBitAndEveryLengthIsRefused) {
    const std::string bytes = pack(owner, co_simulation, "payload");
    ASSERT_EQ(reason_for_refusing(bytes), "accepted");
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        for (unsigned bit = 0; bit < 8; ++bit) {
            std::string damaged = bytes;
            damaged[i] = static_cast<char>(static_cast<unsigned char>(damaged[i]) ^ (1U << bit));
            EXPECT_NE(reason_for_refusing(damaged), "accepted") << "byte " << i << ", bit " << bit;
        }
        EXPECT_NE(reason_for_refusing(bytes.substr(0, i)), "accepted") << "length " << i;
    }
    EXPECT_NE(reason_for_refusing(bytes + '\0'), "accepted");
}

}  // namespace
}  // namespace truenorth::fmi
