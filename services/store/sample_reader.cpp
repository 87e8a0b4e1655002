#include "services/store/sample_reader.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "services/bus/typed.hpp"

namespace tonus::store {
namespace {

std::string samples_text(const StreamKey& stream, SequenceRange range) {
  return fmt::format("samples {} to {} of rig {}, epoch {}", range.first, range.end - 1, to_hex(stream.rig),
                     stream.epoch);
}

/// `count_of` says how many samples the message is of.
template <typename T, typename CountOf>
Result<T> decode_filed(const Block& block, const CountOf& count_of) {
  auto wire = bus::decode<T>(*block.payload);
  if (!wire) {
    return fail(ErrorCode::kDataLoss,
                fmt::format("{} cannot be decoded: {}", samples_text(block.stream, block.range()),
                            wire.error().message));
  }
  const bool is_as_filed = wire->rig_id() == block.stream.rig && wire->epoch() == block.stream.epoch &&
                           wire->first_sequence() == block.first_sequence && count_of(*wire) == block.count;
  if (is_as_filed) return wire;
  return fail(ErrorCode::kDataLoss,
              fmt::format("{} are not what their block holds", samples_text(block.stream, block.range())));
}

}  // namespace

Result<v1::SampleBlock> decode_block(const Block& block) {
  return decode_filed<v1::SampleBlock>(block, [](const auto& wire) { return wire.samples().size(); });
}

Result<v1::AuxiliaryBlock> decode_auxiliary_block(const Block& block) {
  return decode_filed<v1::AuxiliaryBlock>(block, [](const auto& wire) { return wire.sample_count(); });
}

Result<std::vector<v1::RigSample>> read_samples(Store& store, const StreamKey& stream, SequenceRange range) {
  const auto refuse = [&](const std::string& what) {
    return fail(ErrorCode::kDataLoss, fmt::format("store '{}': {}", store.name(), what));
  };
  std::vector<v1::RigSample> samples;
  std::uint64_t next = range.first;
  TONUS_TRY(store.visit_blocks({stream, range}, [&](const Block& block) -> Result<void> {
    if (block.range().end <= next) return {};
    if (block.first_sequence > next)
      return refuse(samples_text(stream, {next, block.first_sequence}) + " are missing");
    const auto wire = decode_block(block);
    if (!wire) return refuse(wire.error().message);
    const std::uint64_t end = std::min(block.range().end, range.end);
    const auto begin = wire->samples().begin();
    samples.insert(samples.end(), begin + static_cast<std::ptrdiff_t>(next - block.first_sequence),
                   begin + static_cast<std::ptrdiff_t>(end - block.first_sequence));
    next = end;
    return {};
  }));
  if (next < range.end) return refuse(samples_text(stream, {next, range.end}) + " are missing");
  return samples;
}

}  // namespace tonus::store
