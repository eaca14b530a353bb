# Every library that is not ours, found once. README.md says why each was chosen.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Boost 1.81 REQUIRED)  # Asio and Beast: headers only
find_package(OpenSSL REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(PNG REQUIRED)
find_package(JPEG REQUIRED)  # libjpeg-turbo in Debian
find_package(TBB REQUIRED)
find_package(tinyobjloader REQUIRED)
find_package(meshoptimizer REQUIRED)
find_package(SQLite3 REQUIRED)
pkg_check_modules(ISAL REQUIRED IMPORTED_TARGET libisal)
find_path(TESSERA_TINYGLTF tiny_gltf.h REQUIRED)  # its CMake target has another name from version to version
find_library(TESSERA_TINYGLTF_LIBRARY tinygltf REQUIRED)
include(cmake/Draco.cmake)
pkg_check_modules(WEBP REQUIRED IMPORTED_TARGET libwebp)
find_path(TESSERA_STB stb/stb_truetype.h REQUIRED)  # headers that are all of it; stb_image.h too
find_file(TESSERA_FONT DejaVuSans.ttf PATHS /usr/share/fonts/truetype/dejavu REQUIRED NO_DEFAULT_PATH)

# Embree 3 in Debian 12, Embree 4 in Debian 13: worker/accel alone knows which.
find_package(embree 4 QUIET)
if(NOT embree_FOUND)
  find_package(embree 3 REQUIRED)
endif()

if(TESSERA_TESTS)
  find_package(GTest REQUIRED)
  find_package(benchmark REQUIRED)
endif()
