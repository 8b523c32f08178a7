# Installs the build tree into a directory of its own, then configures, builds and runs outside projects against it:
# the consumer, and the example of a robot of one's own (without an emulator: it runs live).
# Needs: BUILD (build tree), SOURCE (source tree), WORK (scratch directory), COMPILER; optionally TOOLCHAIN, EMULATOR.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nended with ${code}:\n${output}")
  endif()
  if(output MATCHES "skipped: [^\n]*")  # a part that this machine refuses stays visible
    message(NOTICE "${CMAKE_MATCH_0}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)

function(build name source)
  set(options -G Ninja -S ${source} -B ${WORK}/${name} -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_CXX_COMPILER=${COMPILER} "-DCMAKE_CXX_FLAGS=${FLAGS}")
  if(TOOLCHAIN)
    list(APPEND options -DCMAKE_TOOLCHAIN_FILE=${TOOLCHAIN} -DSORTIE_PREFIX=${WORK}/prefix)
  endif()
  run(${CMAKE_COMMAND} ${options})
  run(${CMAKE_COMMAND} --build ${WORK}/${name})
endfunction()

build(consumer ${SOURCE}/tests/install/consumer)
run(${EMULATOR} ${WORK}/consumer/consumer)
run(${EMULATOR} ${WORK}/prefix/bin/sortie --version)

if(NOT EMULATOR)
  build(own_robot ${SOURCE}/examples/own_robot)
  run(${SOURCE}/tests/install/own_robot.sh ${WORK}/own_robot/gas_robot ${SOURCE} ${WORK}/robot)
endif()

# The installed headers and exported targets name neither the source nor the build tree.
file(GLOB exported ${WORK}/prefix/lib/*/cmake/Sortie/*.cmake ${WORK}/prefix/lib/cmake/Sortie/*.cmake)
foreach(file IN LISTS exported)
  file(READ ${file} text)
  if(text MATCHES "${BUILD}")
    message(FATAL_ERROR "${file} names the build tree")
  endif()
endforeach()
