# The target `draco`: Debian's archive without its readers and writers of glTF. These carry a tinygltf and an stb of their own, which would stand in
# for the ones that are used here (the shared library does that too). draco.pc is no help: it names a folder that is not there in some releases.
find_library(TESSERA_DRACO_ARCHIVE libdraco.a REQUIRED)
set(codec ${CMAKE_BINARY_DIR}/libdraco_codec.a)
execute_process(COMMAND ${CMAKE_AR} t ${TESSERA_DRACO_ARCHIVE} OUTPUT_VARIABLE members COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]*gltf[^\n]*" readers "${members}")
configure_file(${TESSERA_DRACO_ARCHIVE} ${codec} COPYONLY)
execute_process(COMMAND ${CMAKE_AR} d ${codec} ${readers} COMMAND_ERROR_IS_FATAL ANY)
add_library(draco STATIC IMPORTED)
set_target_properties(draco PROPERTIES IMPORTED_LOCATION ${codec})
