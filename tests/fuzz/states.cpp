// Damaged states with right checksums, handed to one FMU (FMI 2). What is accepted is restored, stepped, read
// and stored again. Found is what a sanitizer finds, and a call that hangs.
#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "chance.hpp"
#include "fmi/binary.hpp"
#include "fmi2FunctionTypes.h"
#include "session.hpp"

namespace {

using truenorth::fuzz::Chance;
using truenorth::test::Binary;
using Blob = std::vector<fmi2Byte>;

constexpr std::size_t checksum_place = 12;  // snapshot.cpp: after the magic and the version of the format
constexpr std::size_t content_place = 20;

// NOLINTNEXTLINE(modernize-avoid-variadic-functions): the standard says so
void log(fmi2ComponentEnvironment /*environment*/, fmi2String /*name*/, fmi2Status /*status*/,
         fmi2String /*category*/, fmi2String /*format*/, ...) {}

void seal(Blob& blob) {
    std::uint64_t hash = 0xcbf29ce484222325U;
    for (std::size_t i = content_place; i < blob.size(); ++i) {
        hash ^= static_cast<unsigned char>(blob[i]);
        hash *= 0x100000001b3U;
    }
    std::memcpy(blob.data() + checksum_place, &hash, sizeof hash);
}

class Subject {
  public:
    Subject(const Binary& binary, const std::string& resources) : binary_(binary) {
        callbacks_.logger = log;
        component_ = binary_.function<fmi2InstantiateTYPE>("fmi2Instantiate")(
            "fuzzed", fmi2CoSimulation, binary_.token().c_str(), resources.c_str(), &callbacks_, fmi2False,
            fmi2False);
    }
    Subject(const Subject&) = delete;
    Subject(Subject&&) = delete;
    Subject& operator=(const Subject&) = delete;
    Subject& operator=(Subject&&) = delete;
    ~Subject() { binary_.function<fmi2FreeInstanceTYPE>("fmi2FreeInstance")(component_); }

    template <class Function, class... Arguments>
    bool call(const char* name, Arguments... arguments) {
        return binary_.function<Function>(name)(component_, arguments...) == fmi2OK;
    }

    // A variable that this FMU may not have.
    template <class Function, class Value>
    void set(const char* function, const std::string& name, Value value) {
        const auto found = binary_.references().find(name);
        if (found != binary_.references().end()) {
            call<Function>(function, &found->second, std::size_t{1}, &value);
        }
    }

    // At work for a while, with an IMU at rest and, if there is such an input, fixes.
    void start(Chance& chance) {
        const auto model = static_cast<int>(1 + chance.below(5));
        set<fmi2SetIntegerTYPE>("fmi2SetInteger", "error_model", model);
        set<fmi2SetIntegerTYPE>("fmi2SetInteger", "corrector", static_cast<int>(1 + chance.below(5)));
        set<fmi2SetIntegerTYPE>("fmi2SetInteger", "motion.kind", static_cast<int>(1 + chance.below(3)));
        set<fmi2SetRealTYPE>("fmi2SetReal", "initial.velocity[2]", 0.0);
        call<fmi2SetupExperimentTYPE>("fmi2SetupExperiment", fmi2False, 0.0, 0.0, fmi2False, 0.0);
        call<fmi2EnterInitializationModeTYPE>("fmi2EnterInitializationMode");
        if (!call<fmi2ExitInitializationModeTYPE>("fmi2ExitInitializationMode")) {
            call<fmi2ResetTYPE>("fmi2Reset");  // a combination that makes no sense: as it comes
            call<fmi2EnterInitializationModeTYPE>("fmi2EnterInitializationMode");
            call<fmi2ExitInitializationModeTYPE>("fmi2ExitInitializationMode");
        }
        const int steps = static_cast<int>(chance.below(400));
        for (int k = 1; k <= steps; ++k) {
            set<fmi2SetIntegerTYPE>("fmi2SetInteger", "imu.sample", k);
            set<fmi2SetRealTYPE>("fmi2SetReal", "imu.time", 0.1 * k);
            set<fmi2SetRealTYPE>("fmi2SetReal", "imu.delta_velocity[3]", 0.98);
            set<fmi2SetIntegerTYPE>("fmi2SetInteger", "gnss.sample", k / 10);
            set<fmi2SetRealTYPE>("fmi2SetReal", "gnss.time", static_cast<double>(k / 10));
            set<fmi2SetRealTYPE>("fmi2SetReal", "gnss.latitude", 0.6);
            call<fmi2DoStepTYPE>("fmi2DoStep", 0.1 * (k - 1), 0.1, fmi2True);
        }
    }

    Blob blob() {
        fmi2FMUstate state = nullptr;
        std::size_t size = 0;
        call<fmi2GetFMUstateTYPE>("fmi2GetFMUstate", &state);
        call<fmi2SerializedFMUstateSizeTYPE>("fmi2SerializedFMUstateSize", state, &size);
        Blob blob(size);
        call<fmi2SerializeFMUstateTYPE>("fmi2SerializeFMUstate", state, blob.data(), size);
        call<fmi2FreeFMUstateTYPE>("fmi2FreeFMUstate", &state);
        return blob;
    }

    // Whether it was accepted; then it is lived with.
    bool take(const Blob& blob) {
        fmi2FMUstate state = nullptr;
        if (!call<fmi2DeSerializeFMUstateTYPE>("fmi2DeSerializeFMUstate", blob.data(), blob.size(), &state)) {
            return false;
        }
        const bool accepted = call<fmi2SetFMUstateTYPE>("fmi2SetFMUstate", state);
        call<fmi2FreeFMUstateTYPE>("fmi2FreeFMUstate", &state);
        if (accepted) {
            double time = 0.0;
            call<fmi2GetRealStatusTYPE>("fmi2GetRealStatus", fmi2LastSuccessfulTime, &time);
            for (int k = 0; k < 3; ++k) {
                call<fmi2DoStepTYPE>("fmi2DoStep", time + 0.1 * k, 0.1, fmi2True);
            }
            for (const auto& [name, reference] : binary_.references()) {
                double value = 0.0;
                call<fmi2GetRealTYPE>("fmi2GetReal", &reference, std::size_t{1}, &value);
            }
            static_cast<void>(this->blob());
        }
        return accepted;
    }

  private:
    const Binary& binary_;
    fmi2CallbackFunctions callbacks_{};
    fmi2Component component_;
};

void damage(Blob& blob, std::size_t first, Chance& chance) {
    const auto place = [&](std::size_t size) { return first + chance.below(blob.size() - first - size); };
    switch (chance.below(6)) {
        case 0:  // a byte
            blob[place(1)] = static_cast<fmi2Byte>(chance.integer());
            break;
        case 1: {  // a number
            const double value = chance.real();
            std::memcpy(&blob[place(sizeof value)], &value, sizeof value);
            break;
        }
        case 2: {  // a count
            const std::int64_t value =
                chance.one_in(2) ? chance.integer() : std::int64_t{1} << chance.below(63);
            std::memcpy(&blob[place(sizeof value)], &value, sizeof value);
            break;
        }
        case 3:  // cut short
            blob.resize(first + chance.below(blob.size() - first));
            break;
        case 4:  // made longer, in the middle or at the end
            blob.insert(blob.begin() + static_cast<std::ptrdiff_t>(place(0)), 1 + chance.below(64), '\1');
            break;
        default:  // a stretch of it, elsewhere
            std::memmove(&blob[place(256)], &blob[place(256)], 1 + chance.below(255));
            break;
    }
}

// A hundred damaged states of an FMU at work, then one of another.
class DamagedStates final : public truenorth::fuzz::Session {
  public:
    DamagedStates(const Binary& binary, std::string resources, Chance chance)
        : Session(chance), binary_(binary), resources_(std::move(resources)) {}

    void go_on() override {
        if (left_ == 0) {
            begin();
        }
        Blob damaged = whole_;
        for (std::size_t times = 1 + chance_.below(3); times > 0 && damaged.size() > first_ + 512; --times) {
            damage(damaged, first_, chance_);
        }
        if (damaged.size() >= content_place) {
            seal(damaged);
        }
        watch_.run("damaged state", [&] { return subject_->take(damaged); });
        if (--left_ == 0 && !subject_->take(whole_)) {
            watch_.fail("a sound state was refused");
        }
    }

  private:
    void begin() {
        subject_.emplace(binary_, resources_);
        subject_->start(chance_);
        whole_ = subject_->blob();
        const std::string& owner = binary_.token();
        const auto found = std::search(whole_.begin(), whole_.end(), owner.begin(), owner.end());
        const auto owner_ends = static_cast<std::size_t>(found - whole_.begin()) + owner.size();
        first_ = chance_.one_in(10) ? content_place : owner_ends;
        left_ = 100;
    }

    const Binary& binary_;
    std::string resources_;
    std::optional<Subject> subject_;
    Blob whole_;
    std::size_t first_ = 0;  // place of what is damaged
    int left_ = 0;
};

}  // namespace

std::unique_ptr<truenorth::fuzz::Session> truenorth::fuzz::begin_session(const Binary& binary,
                                                                         const std::string& resources,
                                                                         Chance chance) {
    return std::make_unique<DamagedStates>(binary, resources, chance);
}
