// Values that an exported FMU begins with instead of those it was compiled with.
//
// An export writes them to start_values.txt in the FMU's resources, one line "<name> <value>" for each
// scalar, and appends a checksum to the guid in modelDescription.xml: "<guid>:<16 hexadecimal digits>". It is
// that of the recording beside the file (components/recorded_signals.hpp), if there is one, and then of the
// file. A tool that sets nothing then runs what was exported, and one that does not show the FMU its
// resources, or shows another's, is told so instead of getting other results.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fmi/variable.hpp"

namespace truenorth::fmi {

class StartValues {
  public:
    // None: those compiled in hold.
    StartValues() = default;

    // Those of an export: `mark` is what the token has after the guid, nothing or ":" and the checksum.
    // Throws Refusal when the folder of the resources does not have the file, or has another recording.
    [[nodiscard]] static StartValues marked(std::string_view mark, const std::filesystem::path& resources);

    // Throws Refusal at the first line that is not a value of a parameter or an input.
    void apply(std::span<const Cell> cells) const;

  private:
    std::vector<std::pair<std::string, std::string>> values_;  // by name
};

// Folder that a location means: a path, or a URI of the scheme "file" (FMI 2).
[[nodiscard]] std::filesystem::path folder_of(std::string_view location);

}  // namespace truenorth::fmi
