#include "services/store/store.hpp"

#include <spdlog/fmt/fmt.h>

#include "services/core/crc32c.hpp"

namespace tonus::store {

Result<void> check(const Block& block, const std::string& store_name) {
  if (crc32c(*block.payload) == block.checksum) return {};
  return fail(
      ErrorCode::kDataLoss,
      fmt::format("store '{}': {} {} to {} of rig {}, epoch {}, are damaged: the checksum differs",
                  store_name, block.is_auxiliary ? "auxiliary values of samples" : "samples",
                  block.first_sequence, block.range().end - 1, to_hex(block.stream.rig), block.stream.epoch));
}

Result<void> check(const Message& message, const std::string& store_name) {
  if (crc32c(*message.payload) == message.checksum) return {};
  return fail(ErrorCode::kDataLoss,
              fmt::format("store '{}': a message of {}, key {}, is damaged: the checksum differs", store_name,
                          message.topic, to_hex(message.key)));
}

}  // namespace tonus::store
