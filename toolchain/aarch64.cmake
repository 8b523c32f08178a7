# 64-bit ARM (Raspberry Pi 3 to 5, Jetson): Debian's cross compiler, tests under qemu-user.
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(SORTIE_ARCH arm64)
set(SORTIE_TRIPLE aarch64-linux-gnu)
set(SORTIE_QEMU qemu-aarch64)
include(${CMAKE_CURRENT_LIST_DIR}/cross.cmake)
