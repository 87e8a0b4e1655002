#include "services/archive/sample_reader.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "services/bus/typed.hpp"

namespace tonus::archive {

Result<std::vector<v1::RigSample>> read_samples(Store& store, const StreamKey& stream, SequenceRange range) {
  const auto refuse = [&](std::uint64_t first, std::uint64_t end, std::string_view what) {
    return fail(ErrorCode::kDataLoss,
                fmt::format("store '{}': samples {} to {} of rig {}, epoch {}, {}", store.name(), first,
                            end - 1, to_hex(stream.rig), stream.epoch, what));
  };
  std::vector<v1::RigSample> samples;
  std::uint64_t next = range.first;
  const auto visited = store.visit_blocks({stream, range}, [&](const Block& block) -> Result<void> {
    if (block.range().end <= next) return {};
    if (block.first_sequence > next) return refuse(next, block.first_sequence, "are missing");
    const auto wire = bus::decode<v1::SampleBlock>(*block.payload);
    if (!wire)
      return refuse(block.first_sequence, block.range().end, "cannot be decoded: " + wire.error().message);
    if (wire->samples().size() != block.count || wire->first_sequence() != block.first_sequence) {
      return refuse(block.first_sequence, block.range().end, "are not what their block holds");
    }
    const std::uint64_t end = std::min(block.range().end, range.end);
    const auto begin = wire->samples().begin();
    samples.insert(samples.end(), begin + static_cast<std::ptrdiff_t>(next - block.first_sequence),
                   begin + static_cast<std::ptrdiff_t>(end - block.first_sequence));
    next = end;
    return {};
  });
  if (!visited) return visited.error();
  if (next < range.end) return refuse(next, range.end, "are missing");
  return samples;
}

}  // namespace tonus::archive
