#!/usr/bin/env bash
# Installs the Debian packages that a purpose needs, and nothing if they are there: packages.sh build|test|check|plot|peer …
# Debian 12 (bookworm) and 13 (trixie); as root, or as a user with sudo.
set -euo pipefail

. /etc/os-release
case "${VERSION_CODENAME:-}" in
  bookworm) boost=libboost1.81-dev ;;
  *) boost=libboost-dev ;;
esac

wanted=()
for purpose in "$@"; do
  case "$purpose" in
    build) wanted+=(git ca-certificates cmake ninja-build ccache g++ pkg-config "$boost" libembree-dev libopenexr-dev libtbb-dev
      nlohmann-json3-dev libsqlite3-dev libspdlog-dev libfmt-dev libcli11-dev libssl-dev libpng-dev libjpeg-dev libwebp-dev libisal-dev
      libtinyobjloader-dev libtinygltf-dev libmeshoptimizer-dev libdraco-dev libstb-dev fonts-dejavu-core) ;;
    test) wanted+=(libgtest-dev libgmock-dev libbenchmark-dev nodejs) ;;
    peer) wanted+=(blender python3-numpy npm) ;;
    plot) wanted+=(gnuplot-nox bsdextrautils) ;;
    check) wanted+=(clang-format clang-tidy clang libclang-rt-dev llvm) ;;
    *) echo "packages.sh: unknown purpose \"$purpose\" (expected build, test, check, plot or peer)" >&2; exit 2 ;;
  esac
done

lacking=()
for package in "${wanted[@]}"; do
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || lacking+=("$package")
done
[ ${#lacking[@]} -gt 0 ] || exit 0

as_root=()
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null || { echo "packages.sh: needs root or sudo to install: ${lacking[*]}" >&2; exit 2; }
  as_root=(sudo)
fi
echo "Installing ${#lacking[@]} Debian packages: ${lacking[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${lacking[@]}" >/dev/null
