#include "services/dashboard/gateway/connection_table.hpp"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <utility>

namespace tonus::dashboard {

ConnectionTable::Arrival ConnectionTable::arrive(const std::string& address, std::function<void()> end) {
  Arrival arrival;
  auto victim = places_.end();
  if (count(Standing::kUnproven, address) >= limits_.per_address) {
    victim = oldest_unproven(address);
  } else if (places_.size() >= limits_.all) {
    const auto most = most_unproven_address();
    if (!most) return arrival;
    victim = oldest_unproven(*most);
  }
  if (victim != places_.end()) {
    arrival.gives_way = std::move(victim->second.end);
    places_.erase(victim);
  }
  arrival.number = ++last_;
  places_[last_] = {address, Standing::kUnproven, std::move(end)};
  return arrival;
}

bool ConnectionTable::set_standing(Number number, Standing standing) {
  const auto place = places_.find(number);
  if (place == places_.end()) return false;
  if (standing == Standing::kViewer && place->second.standing != Standing::kViewer) {
    const bool is_room = count(Standing::kViewer) + limits_.reserve < limits_.all &&
                         count(Standing::kViewer, place->second.address) < limits_.per_address;
    if (!is_room) return false;
  }
  place->second.standing = standing;
  return true;
}

std::size_t ConnectionTable::count(Standing standing) const {
  return static_cast<std::size_t>(
      std::count_if(places_.begin(), places_.end(),
                    [standing](const auto& place) { return place.second.standing == standing; }));
}

std::size_t ConnectionTable::count(Standing standing, const std::string& address) const {
  return static_cast<std::size_t>(std::count_if(places_.begin(), places_.end(), [&](const auto& place) {
    return place.second.standing == standing && place.second.address == address;
  }));
}

ConnectionTable::Places::iterator ConnectionTable::oldest_unproven(const std::string& address) {
  return std::find_if(places_.begin(), places_.end(), [&](const auto& place) {
    return place.second.standing == Standing::kUnproven && place.second.address == address;
  });
}

std::optional<std::string> ConnectionTable::most_unproven_address() const {
  std::map<std::string, std::size_t> unproven;
  for (const auto& [number, place] : places_)
    if (place.standing == Standing::kUnproven) ++unproven[place.address];
  const auto most = std::max_element(unproven.begin(), unproven.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == unproven.end() ? std::optional<std::string>() : most->first;
}

std::string counted_address(const std::string& text) {
  namespace ip = boost::asio::ip;
  boost::system::error_code error;
  const ip::address address = ip::make_address(text, error);
  if (error || address.is_v4()) return text;
  const ip::address_v6 v6 = address.to_v6();
  if (v6.is_v4_mapped()) return ip::make_address_v4(ip::v4_mapped, v6).to_string();
  auto bytes = v6.to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), std::uint8_t{0});
  return ip::address_v6(bytes).to_string();
}

}  // namespace tonus::dashboard
