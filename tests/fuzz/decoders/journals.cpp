#include "services/core/clock.hpp"
#include "services/scheduler/journal.hpp"
#include "services/scheduler/session_machine.hpp"
#include "tests/fuzz/decoders/decoder.hpp"
#include "tests/support/memory_storage.hpp"

namespace tonus::fuzz {
namespace {

constexpr std::string_view kContract = "contract";

using tonus::testing::MemoryStorage;

/// A journal's file of these records, the first of which is number 0.
MemoryStorage::Bytes file_of(const std::vector<std::string>& contents) {
  const auto bytes = std::make_shared<MemoryStorage::Bytes>();
  auto file = RecordFile::open(std::make_unique<MemoryStorage>(bytes), {});
  std::uint32_t number = 0;
  for (const auto& content : contents) {
    const std::string record = scheduler::numbered(number++, content);
    (void)file->append(std::as_bytes(std::span(record)));
  }
  return *bytes;
}

/// An odd first byte: a journal as it is. Even: good records of the parts.
MemoryStorage::Bytes journal_of(std::span<const std::byte> input) {
  Parts parts(input);
  if (parts.byte() % 2 == 1) {
    const auto rest = parts.rest();
    return {rest.begin(), rest.end()};
  }
  std::vector<std::string> contents{std::string(kContract)};
  while (!parts.is_empty()) contents.emplace_back(text_of(parts.part()));
  return file_of(contents);
}

}  // namespace

void read_journal(std::span<const std::byte> input) {
  auto bytes = std::make_shared<MemoryStorage::Bytes>(journal_of(input));
  auto opened = scheduler::Journal::open(std::make_unique<MemoryStorage>(std::move(bytes)), kContract);
  require_message(opened);
  if (!opened) return;
  if (const auto written = scheduler::encode_records(opened->records)) {
    const auto again = scheduler::decode_records(*written);
    require(again && scheduler::encode_records(*again).value() == *written,
            "records are the same after they are written and read");
  }
  const ManualClock clock;
  scheduler::SessionMachine machine(clock, "fuzz");
  require_message(machine.restore(opened->records));
}

std::vector<Bytes> journal_seeds() {
  scheduler::record::Started started;
  started.session_id = id_of("session");
  started.protocol_toml = std::string(text_of(source_bytes("deploy/protocols/unloaded.toml")));
  started.subject = "s01";
  started.started_at = "2026-03-01T10:00:00Z";
  scheduler::record::Bound bound;
  bound.rig_id = id_of("rig/fuzz");
  bound.home = {0.0, 0.45};
  scheduler::record::Commanded commanded;
  commanded.program.session_id(started.session_id);
  commanded.program.attempt(1);
  const auto first = scheduler::encode_records({started, bound});
  const auto second = scheduler::encode_records({commanded, scheduler::record::Counted{1, 3.0}});
  const auto third = scheduler::encode_records(
      {scheduler::record::Requested{id_of("request"), v1::SESSION_ABORT}, scheduler::record::Ended{}});
  Bytes framed{std::byte{0}};
  Bytes raw{std::byte{1}};
  std::vector<std::string> contents{std::string(kContract)};
  for (const auto* records : {&first, &second, &third}) {
    put_part(framed, bytes_of(records->value()));
    contents.push_back(records->value());
  }
  const auto all = file_of(contents);
  raw.insert(raw.end(), all.begin(), all.end());
  return {framed, raw};
}

}  // namespace tonus::fuzz
