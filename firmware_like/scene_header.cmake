# The small program that reads a scene as the program does and writes the header for -DSORTIE_SCENE. Not linked with our
# libraries: in such a build they wait for the header that it writes. Where the long tests are built it is built as well, so
# that a file that it lacks is noticed at once.
set(all_scenes ${CMAKE_CURRENT_BINARY_DIR}/all_scenes.cpp)
add_custom_command(OUTPUT ${all_scenes}
  COMMAND ${CMAKE_COMMAND} -DOUT=${all_scenes} "-DFILES=${scene_files}" -P ${PROJECT_SOURCE_DIR}/toolchain/embed_scenes.cmake
  DEPENDS ${scene_files} ${PROJECT_SOURCE_DIR}/toolchain/embed_scenes.cmake VERBATIM)
set(scene_reader scene_header scene_parts profile profile_base profile_rows profile_text text_format toml_file)
list(TRANSFORM scene_reader REPLACE "(.+)" "scene/\\1.cpp")
add_executable(sortie_scene_header ${scene_reader} ${all_scenes})
target_include_directories(sortie_scene_header PRIVATE ${PROJECT_SOURCE_DIR})
target_include_directories(sortie_scene_header SYSTEM PRIVATE ${SORTIE_TOML_INCLUDE})

