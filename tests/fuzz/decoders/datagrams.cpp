#include <algorithm>
#include <initializer_list>

#include "services/bus/fastdds/rtps_check.hpp"
#include "tests/fuzz/decoders/decoder.hpp"

namespace tonus::fuzz {
namespace {

Bytes datagram(std::initializer_list<int> submessages) {
  Bytes bytes = bytes_of("RTPS");
  for (const int byte : {2, 2, 1, 15, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12})
    bytes.push_back(static_cast<std::byte>(byte));
  for (const int byte : submessages) bytes.push_back(static_cast<std::byte>(byte));
  return bytes;
}

void make(std::span<const bus::BytePatch> patches, Bytes& datagram) {
  for (const auto& patch : patches) {
    require(patch.count <= patch.bytes.size() && patch.at + patch.count <= datagram.size(),
            "a patch lies in the datagram");
    std::copy_n(patch.bytes.begin(), patch.count, datagram.begin() + static_cast<std::ptrdiff_t>(patch.at));
  }
}

}  // namespace

void read_rtps(std::span<const std::byte> input) {
  const bus::RtpsChecked checked = bus::check_rtps(input);
  require(!bus::text_of(checked.fault).empty() || checked.fault == bus::RtpsFault::kNone,
          "a fault has a name");
  if (checked.fault != bus::RtpsFault::kNone) {
    require(checked.message.empty(), "nothing of a faulty datagram is parsed");
    return;
  }
  require(checked.message.size() <= input.size(), "what is parsed lies in the datagram");
  Bytes patched(input.begin(), input.end());
  make(checked.patches, patched);
  for (const auto& word : checked.acknowledgements)
    require(word.at < input.size() && word.count_at + 4 <= input.size(),
            "an acknowledgement lies in the datagram");
  patched.resize(checked.message.size());
  const bus::RtpsChecked again = bus::check_rtps(patched);
  require(again.fault == bus::RtpsFault::kNone, "what was let through and patched is let through again");
  const Bytes once = patched;
  make(again.patches, patched);
  require(patched == once, "a patch that is made twice changes nothing");
}

std::vector<Bytes> rtps_seeds() {
  return {
      datagram({}),
      // INFO_TS, then HEARTBEAT of the writer of participants.
      datagram({9, 1,    8, 0, 1, 2, 3, 4, 5, 6, 7, 8, 7, 1, 28, 0, 0, 0, 0, 0, 0, 1,
                0, 0xc2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1,  0, 0, 0, 1, 0, 0, 0}),
      // ACKNACK: base 1, no bits, count 1.
      datagram({6, 3, 24, 0, 0, 0, 3, 0xc7, 0, 0, 3, 0xc2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0}),
      // DATA of the participants' writer with a parameter list: lease 3 s, then the end.
      datagram({0x15, 5, 44, 0, 0, 0, 16, 0, 0, 0, 0, 0, 0, 1, 0, 0xc2, 0, 0, 0, 0, 1, 0, 0, 0,
                0,    3, 0,  0, 2, 0, 8,  0, 3, 0, 0, 0, 0, 0, 0, 0,    1, 0, 0, 0, 0, 0, 0, 0}),
      // DATA_FRAG of an application's writer.
      datagram({0x16, 1, 36, 0, 0, 0, 28, 0, 0, 0, 0, 0, 0, 0, 1, 3, 0, 0, 0, 0,
                1,    0, 0,  0, 1, 0, 0,  0, 1, 0, 4, 0, 8, 0, 0, 0, 1, 2, 3, 4})};
}

}  // namespace tonus::fuzz
