# cmake -DOUTPUT=web_data.cpp "-DFILES=a;b" -P embed.cmake: the bytes of files as a C++ source, for web_data.hpp.
set(arrays "")
set(entries "")
set(index 0)
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  file(READ ${file} hex HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${hex}")
  string(APPEND arrays "constexpr char file_${index}[] = {${bytes}'\\0'};\n")
  string(APPEND entries "    {\"${name}\", file_${index}, sizeof file_${index} - 1},\n")
  math(EXPR index "${index} + 1")
endforeach()
file(WRITE ${OUTPUT} "#include \"server/http/web_data.hpp\"

namespace tessera::server {
namespace {
${arrays}
constexpr WebData all[] = {
${entries}};
}  // namespace

std::span<const WebData> web_data() { return all; }

}  // namespace tessera::server
")
