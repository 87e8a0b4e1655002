// A stand-in for the calls of libcomedi that the driver makes, linked in its place.
#include "tests/unit/rig_agent/drivers/fake_comedi.hpp"

#include <algorithm>
#include <cmath>
#include <comedilib.h>

namespace {

constexpr unsigned kInputs = 0;
constexpr unsigned kOutputs = 1;
constexpr unsigned kLines = 2;
constexpr unsigned kCounters = 3;

int last_error = 0;
comedi_range ranges[2] = {};

tonus::drivers::FakeCard& card() { return tonus::drivers::fake_card(); }

int failed(int error) {
  last_error = error;
  return -1;
}

int channels_of(unsigned subdevice) { return subdevice == kLines ? 8 : subdevice <= kCounters ? 2 : -1; }

bool is_channel(unsigned subdevice, unsigned channel) {
  return static_cast<int>(channel) < channels_of(subdevice);
}

}  // namespace

namespace tonus::drivers {
FakeCard& fake_card() {
  static FakeCard the_card;
  return the_card;
}
}  // namespace tonus::drivers

extern "C" {

comedi_t* comedi_open(const char* device) {
  if (!card().is_there || card().device != device) {
    failed(2);
    return nullptr;
  }
  ++card().open_cards;
  return reinterpret_cast<comedi_t*>(&card());
}

int comedi_close(comedi_t*) {
  --card().open_cards;
  return 0;
}

int comedi_loglevel(int) { return 0; }
int comedi_errno(void) { return last_error; }
const char* comedi_strerror(int error) { return error == 2 ? "No such device" : "Invalid specification"; }

int comedi_get_subdevice_type(comedi_t*, unsigned subdevice) {
  switch (subdevice) {
    case kInputs:
      return COMEDI_SUBD_AI;
    case kOutputs:
      return COMEDI_SUBD_AO;
    case kLines:
      return COMEDI_SUBD_DIO;
    case kCounters:
      return COMEDI_SUBD_COUNTER;
    default:
      return failed(3);
  }
}

int comedi_get_n_channels(comedi_t*, unsigned subdevice) { return channels_of(subdevice); }

lsampl_t comedi_get_maxdata(comedi_t*, unsigned subdevice, unsigned channel) {
  if (!is_channel(subdevice, channel)) return 0;
  return subdevice == kCounters ? card().counter_largest : card().analogue_largest;
}

comedi_range* comedi_get_range(comedi_t*, unsigned subdevice, unsigned channel, unsigned range) {
  if (!is_channel(subdevice, channel) || range > 0 || subdevice > kOutputs) {
    failed(3);
    return nullptr;
  }
  comedi_range& found = ranges[subdevice];
  found.min = subdevice == kInputs ? card().input_range[0] : -10.0;
  found.max = subdevice == kInputs ? card().input_range[1] : 10.0;
  found.unit = UNIT_volt;
  return &found;
}

int comedi_data_read(comedi_t*, unsigned subdevice, unsigned channel, unsigned, unsigned, lsampl_t* data) {
  if (!card().is_connected || !is_channel(subdevice, channel)) return failed(3);
  if (subdevice == kCounters) {
    *data = card().counter[channel];
    return 1;
  }
  const auto [low, high] = card().input_range;
  const double share = (std::clamp(card().volts_in[channel], low, high) - low) / (high - low);
  *data = static_cast<lsampl_t>(std::lround(share * card().analogue_largest));
  return 1;
}

int comedi_data_write(comedi_t*, unsigned subdevice, unsigned channel, unsigned, unsigned, lsampl_t data) {
  if (!card().is_connected || !is_channel(subdevice, channel)) return failed(3);
  if (subdevice == kCounters) card().counter[channel] = data;
  if (subdevice == kOutputs) card().output[channel] = data;
  return 1;
}

int comedi_dio_config(comedi_t*, unsigned subdevice, unsigned channel, unsigned direction) {
  return subdevice == kLines && channel < 8 && (direction == COMEDI_INPUT || direction == COMEDI_OUTPUT)
             ? 0
             : failed(3);
}

int comedi_dio_write(comedi_t*, unsigned subdevice, unsigned channel, unsigned bit) {
  if (!card().is_connected || subdevice != kLines || channel >= 8) return failed(3);
  card().line[channel] = bit;
  return 1;
}

int comedi_dio_read(comedi_t*, unsigned subdevice, unsigned channel, unsigned* bit) {
  if (!card().is_connected || subdevice != kLines || channel >= 8) return failed(3);
  *bit = card().line[channel];
  return 1;
}

int comedi_reset_channel(comedi_t*, unsigned, unsigned) { return card().takes_counter_modes ? 0 : failed(3); }

int comedi_set_counter_mode(comedi_t*, unsigned, unsigned, unsigned mode) {
  if (!card().takes_counter_modes) return failed(3);
  card().counter_mode = mode;
  return 0;
}

int comedi_arm_channel(comedi_t*, unsigned, unsigned, unsigned) {
  ++card().armed_counters;
  return 0;
}

}  // extern "C"
