# 32-bit ARM with hardware float (Raspberry Pi 2, BeagleBone): Debian's cross compiler, tests under qemu-user.
set(CMAKE_SYSTEM_PROCESSOR arm)
set(SORTIE_ARCH armhf)
set(SORTIE_TRIPLE arm-linux-gnueabihf)
set(SORTIE_QEMU qemu-arm)
include(${CMAKE_CURRENT_LIST_DIR}/cross.cmake)
