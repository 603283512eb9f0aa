# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
#
# cmake -DINPUT=foo.spv -DOUTPUT=foo.cpp -DNAME=foo -P embed_spirv.cmake
# SPIR-V is a stream of 32-bit words; glslang writes them little-endian on every host that we build on.
file(READ "${INPUT}" hex HEX)
string(LENGTH "${hex}" digits)
math(EXPR words "${digits} / 8")
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," body "${hex}")
file(WRITE "${OUTPUT}" "// Generated from ${NAME}.comp.\n#include <cstddef>\n#include <cstdint>\n"
     "namespace wavefront::spirv_data {\nextern const uint32_t k_${NAME}_words[];\nextern const size_t k_${NAME}_count;\n"
     "const uint32_t k_${NAME}_words[] = {${body}};\nconst size_t k_${NAME}_count = ${words};\n}\n")
