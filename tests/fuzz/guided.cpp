// Sessions that libFuzzer guides by what of the FMU they reach:
//
//     FUZZED="BINARY MODEL_DESCRIPTION" PROGRAM [OPTION OF LIBFUZZER | FOLDER]...
//
// Which FMU, the environment says: libFuzzer starts the program anew when it merges folders (-merge=1).
#include <cstdio>
#include <cstdlib>
#include <span>
#include <sstream>
#include <string>

#include "components/recording_file.hpp"
#include "session.hpp"

namespace {

struct Subject {
    Subject(const std::string& binary_file, const std::string& description)
        : binary(binary_file, description) {
        resources.put(truenorth::RecordingFile{}.bytes());
    }

    static Subject of_environment() {
        const char* const fuzzed = std::getenv("FUZZED");
        std::istringstream words(fuzzed == nullptr ? "" : fuzzed);
        std::string binary_file;
        std::string description;
        if (!(words >> binary_file >> description)) {
            std::fprintf(stderr, "FUZZED names no binary and model description\n");
            std::exit(2);
        }
        return {binary_file, description};
    }

    truenorth::test::Binary binary;
    truenorth::ResourceFolder resources;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const Subject subject = Subject::of_environment();
    const auto session = truenorth::fuzz::begin_session(subject.binary, subject.resources.path().string(),
                                                        truenorth::fuzz::Chance(std::span(data, size)));
    while (!session->spent()) {
        session->go_on();
    }
    return 0;
}
