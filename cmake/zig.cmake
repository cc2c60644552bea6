# Cross builds with the compiler of the Python package `ziglang`: clang, libc++ and the C libraries of every target.
# TRUENORTH_ZIG_TARGET is Zig's name of the target, e.g. x86_64-linux-gnu.2.17 (the last part is the glibc floor)
# or aarch64-macos.11.0 (the oldest macOS).
set(TRUENORTH_ZIG_TARGET "" CACHE STRING "Zig's name of the target")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES TRUENORTH_ZIG_TARGET ZIG)

file(GLOB zig_folders ${CMAKE_CURRENT_LIST_DIR}/../.venv/lib/python*/site-packages/ziglang)
find_program(ZIG zig HINTS ${zig_folders} REQUIRED)

string(REGEX MATCH "^[^-]+" CMAKE_SYSTEM_PROCESSOR "${TRUENORTH_ZIG_TARGET}")
if(TRUENORTH_ZIG_TARGET MATCHES "windows")
  set(CMAKE_SYSTEM_NAME Windows)
elseif(TRUENORTH_ZIG_TARGET MATCHES "macos")
  set(CMAKE_SYSTEM_NAME Darwin)
else()
  set(CMAKE_SYSTEM_NAME Linux)
endif()

set(CMAKE_CXX_COMPILER ${ZIG} c++ -target ${TRUENORTH_ZIG_TARGET})

# CMake wants archivers that are one word.
foreach(tool ar ranlib)
  string(TOUPPER ${tool} variable)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/zig-${tool} CONTENT "#!/bin/sh\nexec '${ZIG}' ${tool} \"$@\"\n" @ONLY)
  file(CHMOD ${CMAKE_BINARY_DIR}/zig-${tool} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  set(CMAKE_${variable} ${CMAKE_BINARY_DIR}/zig-${tool} CACHE FILEPATH "" FORCE)
endforeach()
