# Cortex-M4F, doubles in software, nothing beneath: Debian's arm-none-eabi compiler with picolibc, run by QEMU's mps2-an386.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(SORTIE_CPU -mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16 -mthumb)
list(JOIN SORTIE_CPU " " cpu)
set(CMAKE_CXX_FLAGS_INIT "${cpu} --specs=picolibcpp.specs -fno-exceptions -fno-rtti -fno-threadsafe-statics -ffunction-sections -fdata-sections")
