// Sessions on one FMU, each in a thread of its own, with a seed of its own; or one for each file of a folder,
// whose bytes are what happens:
//
//     PROGRAM BINARY MODEL_DESCRIPTION SEED COUNT [THREADS]
//     PROGRAM BINARY MODEL_DESCRIPTION FOLDER
//
// COUNT is that of all threads together.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "components/recording_file.hpp"
#include "session.hpp"

namespace {

using truenorth::fuzz::Chance;
using truenorth::fuzz::Watch;
using truenorth::test::Binary;

int replay(const Binary& binary, const std::string& resources, const std::filesystem::path& folder) {
    long files = 0;
    long calls = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        std::ifstream file(entry.path(), std::ios::binary);
        const std::vector<std::uint8_t> bytes{std::istreambuf_iterator(file), {}};
        const auto session = truenorth::fuzz::begin_session(binary, resources, Chance(bytes));
        while (!session->spent()) {
            session->go_on();
        }
        ++files;
        calls += session->watch().calls();
    }
    std::printf("%s: %ld files, %ld calls\n", folder.c_str(), files, calls);
    return files > 0 ? 0 : 1;
}

void run(const Binary& binary, const std::string& resources, std::uint64_t seed, long count,
         std::size_t threads) {
    std::printf("seed %lu, %ld calls in each of %zu threads\n", seed, count, threads);
    std::vector<Watch> watches(threads);
    std::vector<std::thread> running;
    for (std::size_t i = 0; i < threads; ++i) {
        running.emplace_back([&, i] {
            const auto session = truenorth::fuzz::begin_session(binary, resources, Chance(seed + i));
            while (session->watch().calls() < count) {
                session->go_on();
            }
            watches[i] = session->watch();
        });
    }
    for (std::thread& thread : running) {
        thread.join();
    }
    for (const Watch& watch : watches) {
        watch.print();
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 4 || argc > 6) {
        std::fprintf(stderr, "usage: %s BINARY MODEL_DESCRIPTION {SEED COUNT [THREADS] | FOLDER}\n", argv[0]);
        return 2;
    }
    std::printf("%s: ", argv[1]);
    const Binary binary(argv[1], argv[2]);
    const truenorth::ResourceFolder resources;
    resources.put(truenorth::RecordingFile{}.bytes());
    if (argc == 4) {
        return replay(binary, resources.path().string(), argv[3]);
    }
    const std::size_t threads = argc == 6 ? std::stoul(argv[5]) : 1;
    run(binary, resources.path().string(), std::stoull(argv[3]),
        std::stol(argv[4]) / static_cast<long>(threads), threads);
    return 0;
}
