#pragma once
#include "common/io/byte_stream.hpp" // ByteWriter, ByteReader: the payloads that are not batches

namespace talik::exchange {
using talik::ByteReader;
using talik::ByteWriter;
} // namespace talik::exchange
