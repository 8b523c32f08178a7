# What `cmake --install` puts where, and what find_package(Sortie) finds: Sortie::rt, Sortie::drivers and so on, with
# the flags of repeatable arithmetic attached, and headers that are included as in the repository ("rt/status.hpp").
include(CMakePackageConfigHelpers)
set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Sortie)

install(TARGETS sortie_strict sortie_rt sortie_rt_convex sortie_rt_posix sortie_messages sortie_drivers sortie_estimators sortie_mapping
  sortie_planner sortie_runtime EXPORT SortieTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET sortie_firmware)  # A program of one scene has no desk.
  install(TARGETS sortie_hil sortie_tools sortie_firmware EXPORT SortieTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
endif()
if(TARGET sortie_heap_trap)
  install(TARGETS sortie_heap_trap EXPORT SortieTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    OBJECTS DESTINATION ${CMAKE_INSTALL_LIBDIR}/sortie)
endif()
install(EXPORT SortieTargets NAMESPACE Sortie:: DESTINATION ${config_dir})
install(TARGETS sortie RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

foreach(folder rt drivers estimators mapping planner hil firmware_like toolchain)
  install(DIRECTORY ${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/sortie FILES_MATCHING PATTERN "*.hpp"
    PATTERN "toolchain/package" EXCLUDE)
endforeach()
# The headers of a robot of one's own, under the names that such projects know.
install(DIRECTORY toolchain/package/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/sortie FILES_MATCHING PATTERN "*.hpp")
install(DIRECTORY firmware_like/scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/sortie FILES_MATCHING PATTERN "*.toml")
# The names that systemd looks for below a prefix of /usr or /usr/local; elsewhere they are there to be copied.
install(FILES toolchain/service/sortie@.service DESTINATION lib/systemd/system)
install(FILES toolchain/service/sortie.sysusers.conf DESTINATION lib/sysusers.d RENAME sortie.conf)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/sortie)

configure_package_config_file(toolchain/SortieConfig.cmake.in ${PROJECT_BINARY_DIR}/SortieConfig.cmake
  INSTALL_DESTINATION ${config_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/SortieConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/SortieConfig.cmake ${PROJECT_BINARY_DIR}/SortieConfigVersion.cmake
  DESTINATION ${config_dir})
