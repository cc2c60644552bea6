// Runs sessions of random calls on one FMU, each in a thread of its own, with a seed of its own:
//
//     PROGRAM BINARY MODEL_DESCRIPTION SEED CALLS [THREADS]
//
// CALLS are those of all threads together.
#pragma once

#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "components/recording_file.hpp"
#include "fmi/binary.hpp"
#include "watch.hpp"

namespace truenorth::fuzz {

template <class Session>
int run_sessions(int argc, char** argv) {
    if (argc != 5 && argc != 6) {
        std::fprintf(stderr, "usage: %s BINARY MODEL_DESCRIPTION SEED CALLS [THREADS]\n", argv[0]);
        return 2;
    }
    const test::Binary binary(argv[1], argv[2]);
    const auto seed = std::stoull(argv[3]);
    const std::size_t threads = argc == 6 ? std::stoul(argv[5]) : 1;
    const long calls = std::stol(argv[4]) / static_cast<long>(threads);
    const ResourceFolder resources;
    resources.put(RecordingFile{}.bytes());
    std::printf("%s: seed %llu, %ld calls in each of %zu threads\n", argv[1], seed, calls, threads);
    std::vector<Watch> watches(threads);
    std::vector<std::thread> running;
    for (std::size_t i = 0; i < threads; ++i) {
        running.emplace_back([&, i] {
            Session session(binary, resources.path().string(), seed + i);
            while (session.watch().calls() < calls) {
                session.call_any();
            }
            watches[i] = session.watch();
        });
    }
    for (std::thread& thread : running) {
        thread.join();
    }
    for (const Watch& watch : watches) {
        watch.print();
    }
    return 0;
}

}  // namespace truenorth::fuzz
