#include "services/store/block_header.hpp"

#include <array>
#include <fastcdr/Cdr.h>
#include <spdlog/fmt/fmt.h>

#include "idl/bounds.hpp"
#include "services/bus/payload.hpp"
#include "services/bus/typed.hpp"
#include "services/contract/block_bounds.hpp"

namespace tonus::store {
namespace {

/// The members of v1::SampleBlock before its samples, in their order, and the number of samples.
struct Header {
  Id rig{};
  Id session{};
  Id trial{};
  std::uint64_t epoch = 0;
  std::uint64_t first_sequence = 0;
  bool is_resent = false;
  std::int64_t sent = 0;
  std::uint32_t samples = 0;

  void deserialize(eprosima::fastcdr::Cdr& cdr) {
    cdr >> rig >> session >> trial >> epoch >> first_sequence >> is_resent >> sent >> samples;
  }
};

/// The members of v1::AuxiliaryBlock before its values, in their order, and the number of values.
struct AuxiliaryMembers {
  Id rig{};
  Id session{};
  Id trial{};
  std::uint64_t epoch = 0;
  std::uint64_t first_sequence = 0;
  std::uint32_t samples = 0;
  bool is_resent = false;
  std::uint32_t values = 0;

  void deserialize(eprosima::fastcdr::Cdr& cdr) {
    cdr >> rig >> session >> trial >> epoch >> first_sequence >> samples >> is_resent >> values;
  }
};

using contract::kMostAuxiliaryValues;
using contract::kMostBlockSamples;

Result<void> check_numbers(const char* topic, std::uint64_t first_sequence, std::uint64_t epoch) {
  if (first_sequence <= kLargestSequence && epoch <= kLargestSequence) return {};
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("{}: first_sequence {} and epoch {} are not allowed; expected at most {} each",
                          topic, first_sequence, epoch, kLargestSequence));
}

/// The payload is as long as its members, which end with `count` of `what`.
Result<void> check_bytes(std::size_t payload, std::size_t members, std::uint32_t count, const char* what) {
  const std::size_t whole = bus::kEncapsulationBytes + members;
  if (payload >= whole) return bus::detail::check_extent(payload, whole, members);
  return fail(
      ErrorCode::kInvalidArgument,
      fmt::format("payload of {} bytes is not allowed; expected {} for {} {}", payload, whole, count, what));
}

/// What both kinds of block say of themselves.
template <typename Members>
Block block_of(const Members& members) {
  Block block;
  block.stream = {members.rig, members.epoch};
  block.first_sequence = members.first_sequence;
  block.count = members.samples;
  block.session = members.session;
  block.trial = members.trial;
  block.is_resent = members.is_resent;
  return block;
}

/// Bytes of a block's members with so many samples.
std::size_t member_bytes(std::size_t samples) {
  v1::SampleBlock block;
  block.samples().resize(samples);
  return v1::SampleBlock::getCdrSerializedSize(block);
}

}  // namespace

Result<Block> read_block_header(std::span<const std::byte> payload) {
  static const std::size_t kOne = member_bytes(1);
  static const std::size_t kMore = member_bytes(2) - kOne;  // each later one is aligned as the second
  Header header;
  const auto read = bus::detail::decode_members(
      payload, &header,
      [](void* target, eprosima::fastcdr::Cdr& cdr) { static_cast<Header*>(target)->deserialize(cdr); });
  if (!read) return read.error();
  const std::size_t count = header.samples;
  if (count == 0)
    return fail(ErrorCode::kInvalidArgument,
                "rig/samples: a block of 0 samples is not allowed; expected 1 to 256");
  if (count > kMostBlockSamples) {
    return fail(ErrorCode::kInvalidArgument,
                v1::out_of_bounds("SampleBlock.samples", count, kMostBlockSamples));
  }
  TONUS_TRY(check_bytes(payload.size(), kOne + (count - 1) * kMore, header.samples, "samples"));
  TONUS_TRY(check_numbers("rig/samples", header.first_sequence, header.epoch));
  return block_of(header);
}

Result<AuxiliaryHeader> read_auxiliary_header(std::span<const std::byte> payload) {
  static const std::size_t kNone = v1::AuxiliaryBlock::getCdrSerializedSize(v1::AuxiliaryBlock());
  AuxiliaryMembers members;
  TONUS_TRY(bus::detail::decode_members(payload, &members, [](void* target, eprosima::fastcdr::Cdr& cdr) {
    static_cast<AuxiliaryMembers*>(target)->deserialize(cdr);
  }));
  const auto refuse = [](std::string what) { return fail(ErrorCode::kInvalidArgument, std::move(what)); };
  if (members.samples == 0 || members.samples > kMostBlockSamples) {
    return refuse(fmt::format("rig/auxiliary: sample_count {} is not allowed; expected 1 to {}",
                              members.samples, kMostBlockSamples));
  }
  if (members.values > kMostAuxiliaryValues)
    return refuse(v1::out_of_bounds("AuxiliaryBlock.values", members.values, kMostAuxiliaryValues));
  if (members.values == 0 || members.values % members.samples != 0) {
    return refuse(
        fmt::format("rig/auxiliary: {} values of {} samples are not allowed; expected the same "
                    "number for each",
                    members.values, members.samples));
  }
  TONUS_TRY(check_bytes(payload.size(), kNone + sizeof(float) * members.values, members.values, "values"));
  TONUS_TRY(check_numbers("rig/auxiliary", members.first_sequence, members.epoch));
  AuxiliaryHeader header;
  header.block = block_of(members);
  header.block.is_auxiliary = true;
  header.values_per_sample = members.values / members.samples;
  return header;
}

}  // namespace tonus::store
