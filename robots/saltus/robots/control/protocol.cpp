#include "saltus/robots/control/protocol.hpp"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <type_traits>

#include "saltus/core/error.hpp"
#include "saltus/robots/control/robot_link.hpp"

namespace saltus::robots::control {
namespace {

constexpr std::uint32_t magic = 0x4c544c53;  // "SLTL"
constexpr std::uint16_t sensors = 1, command = 2;
constexpr std::size_t header_size = 40, checksum_at = 12;
constexpr std::size_t sensor_size = header_size + 8 * 24, command_size = header_size + 16;
constexpr unsigned stop_flag = 1, guard_flag = 2;
constexpr double nanoseconds = 1e9;

// Writes or reads the fields one after another.
template <class Integer>
void store(std::byte*& at, Integer value) {
  for (std::size_t i = 0; i < sizeof value; ++i) *at++ = static_cast<std::byte>(value >> (8 * i));
}
void store(std::byte*& at, double value) { store(at, std::bit_cast<std::uint64_t>(value)); }
template <class Vector>
void store_all(std::byte*& at, const Vector& values) {
  for (const double v : values) store(at, v);
}
template <class Integer>
Integer load(const std::byte*& at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(Integer); ++i)
    value |= std::to_integer<std::uint64_t>(*at++) << (8 * i);
  return static_cast<Integer>(value);
}
double load_number(const std::byte*& at) { return std::bit_cast<double>(load<std::uint64_t>(at)); }
template <class Vector>
void load_all(const std::byte*& at, Vector& values) {
  for (double& v : values) v = load_number(at);
}

std::uint64_t stamp(double seconds) {
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::llround(seconds * nanoseconds)));
}
double seconds(std::uint64_t stamp) {
  return static_cast<double>(static_cast<std::int64_t>(stamp)) / nanoseconds;
}

std::size_t size_of(std::uint16_t type, int joints) {
  const auto n = static_cast<std::size_t>(joints);
  return type == sensors ? sensor_size + 16 * n : command_size + 40 * n;
}

constexpr std::array<std::uint32_t, 256> crc_table = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1U) != 0 ? 0xedb88320U ^ (c >> 1) : c >> 1;
    table[i] = c;
  }
  return table;
}();
std::uint32_t continue_crc(std::uint32_t crc, std::span<const std::byte> bytes) {
  for (const std::byte b : bytes)
    crc = crc_table[(crc ^ std::to_integer<std::uint32_t>(b)) & 0xffU] ^ (crc >> 8);
  return crc;
}
// The checksum counts itself as zeros.
std::uint32_t checksum(std::span<const std::byte> message) {
  constexpr std::array<std::byte, 4> zeros{};
  std::uint32_t crc = continue_crc(~0U, message.first(checksum_at));
  crc = continue_crc(crc, zeros);
  return ~continue_crc(crc, message.subspan(checksum_at + zeros.size()));
}

struct Header {
  std::uint16_t flags = 0;
  std::uint64_t sequence = 0, time = 0;
};

std::byte* begin(std::vector<std::byte>& bytes, std::uint16_t type, std::uint32_t robot, int joints,
                 const Header& header) {
  std::byte* at = bytes.data();
  store(at, magic);
  store(at, protocol_version);
  store(at, type);
  store(at, static_cast<std::uint32_t>(size_of(type, joints)));
  store(at, std::uint32_t{0});
  store(at, robot);
  store(at, static_cast<std::uint16_t>(joints));
  store(at, header.flags);
  store(at, header.sequence);
  store(at, header.time);
  return at;
}

std::span<const std::byte> finish(std::vector<std::byte>& bytes, std::size_t size) {
  const std::span<std::byte> message(bytes.data(), size);
  std::byte* at = message.data() + checksum_at;
  store(at, checksum(message));
  return message;
}

Refusal check(std::span<const std::byte> bytes, std::uint16_t type, std::uint32_t robot, int joints,
              Header& header) {
  if (bytes.size() < header_size) return Refusal::truncated;
  const std::byte* at = bytes.data();
  if (load<std::uint32_t>(at) != magic) return Refusal::foreign;
  if (load<std::uint16_t>(at) != protocol_version) return Refusal::version;
  const auto given_type = load<std::uint16_t>(at);
  if (load<std::uint32_t>(at) != bytes.size()) return Refusal::truncated;
  if (load<std::uint32_t>(at) != checksum(bytes)) return Refusal::checksum;
  if (given_type != type) return Refusal::type;
  const auto given_robot = load<std::uint32_t>(at);
  if (load<std::uint16_t>(at) != joints) return Refusal::joint_count;
  if (given_robot != robot) return Refusal::robot;
  header.flags = load<std::uint16_t>(at);
  header.sequence = load<std::uint64_t>(at);
  header.time = load<std::uint64_t>(at);
  return bytes.size() == size_of(type, joints) ? Refusal::none : Refusal::truncated;
}

std::uint32_t identity(std::span<const std::string> joints) {
  std::uint32_t crc = ~0U;
  for (const std::string& name : joints) {
    crc = continue_crc(crc, std::as_bytes(std::span(name)));
    crc = continue_crc(crc, std::as_bytes(std::span("\n", 1)));
  }
  return ~crc;
}

}  // namespace

bool SensorMessage::is_finite() const {
  return std::isfinite(time) && std::isfinite(pace) && angular_velocity.allFinite() &&
         specific_force.allFinite() && orientation.allFinite() && left.allFinite() &&
         right.allFinite() && q.allFinite() && dq.allFinite();
}

const char* describe(ControlState state) {
  constexpr std::array names{"start", "stand", "balance", "hold", "damp", "release", "check"};
  const auto i = static_cast<std::size_t>(state);
  return i < names.size() ? names[i] : "unknown";
}

const char* describe(Refusal refusal) {
  switch (refusal) {
    case Refusal::none:
      return "valid";
    case Refusal::truncated:
      return "its size is wrong";
    case Refusal::foreign:
      return "it is not a message of this protocol";
    case Refusal::version:
      return "it has another version of the protocol";
    case Refusal::checksum:
      return "its checksum is wrong";
    case Refusal::type:
      return "it is of the wrong kind";
    case Refusal::joint_count:
      return "it is for another number of joints";
    case Refusal::robot:
      return "it is for a robot with other joints";
  }
  return "";
}

std::uint32_t crc32(std::span<const std::byte> bytes) { return ~continue_crc(~0U, bytes); }

Codec::Codec(std::span<const std::string> joints)
    : joints_(static_cast<int>(joints.size())), robot_(identity(joints)) {
  constexpr std::size_t most = (RobotLink::most_bytes - command_size) / 40;  // bytes of a joint
  if (joints.empty() || joints.size() > most)
    throw DefinitionError(
        fmt::format("robot link: a robot has at least one joint and at most {}", most));
  bytes_.resize(std::max(size_of(sensors, joints_), size_of(command, joints_)));
}

std::span<const std::byte> Codec::encode(const SensorMessage& m) {
  std::byte* at = begin(bytes_, sensors, robot_, joints_,
                        {static_cast<std::uint16_t>((m.requests_stop ? stop_flag : 0) |
                                                    (m.is_guarded ? guard_flag : 0)),
                         m.sequence, stamp(m.time)});
  store(at, m.pace);
  store(at, 0.0);  // reserved
  store_all(at, m.angular_velocity);
  store_all(at, m.specific_force);
  store_all(at, m.orientation);
  store_all(at, m.left);
  store_all(at, m.right);
  store_all(at, m.q);
  store_all(at, m.dq);
  return finish(bytes_, size_of(sensors, joints_));
}

std::span<const std::byte> Codec::encode(const CommandMessage& m) {
  std::byte* at = begin(bytes_, command, robot_, joints_, {0, m.sequence, stamp(m.time)});
  store(at, m.answers);
  store(at, static_cast<std::uint32_t>(m.state));
  store(at, std::uint32_t{0});
  const Robot::Commands& c = m.commands;
  for (const VectorXd* part : {&c.torques, &c.positions, &c.velocities, &c.stiffness, &c.damping})
    store_all(at, *part);
  return finish(bytes_, size_of(command, joints_));
}

Refusal Codec::decode(std::span<const std::byte> bytes, SensorMessage& m) const {
  Header header;
  const Refusal refusal = check(bytes, sensors, robot_, joints_, header);
  if (refusal != Refusal::none) return refusal;
  m.sequence = header.sequence;
  m.time = seconds(header.time);
  m.requests_stop = (header.flags & stop_flag) != 0;
  m.is_guarded = (header.flags & guard_flag) != 0;
  m.q.resize(joints_);
  m.dq.resize(joints_);
  const std::byte* at = bytes.data() + header_size;
  m.pace = load_number(at);
  load_number(at);
  load_all(at, m.angular_velocity);
  load_all(at, m.specific_force);
  load_all(at, m.orientation);
  load_all(at, m.left);
  load_all(at, m.right);
  load_all(at, m.q);
  load_all(at, m.dq);
  return Refusal::none;
}

Refusal Codec::decode(std::span<const std::byte> bytes, CommandMessage& m) const {
  Header header;
  const Refusal refusal = check(bytes, command, robot_, joints_, header);
  if (refusal != Refusal::none) return refusal;
  m.sequence = header.sequence;
  m.time = seconds(header.time);
  const std::byte* at = bytes.data() + header_size;
  m.answers = load<std::uint64_t>(at);
  m.state = static_cast<ControlState>(load<std::uint32_t>(at));
  load<std::uint32_t>(at);
  Robot::Commands& c = m.commands;
  for (VectorXd* part : {&c.torques, &c.positions, &c.velocities, &c.stiffness, &c.damping}) {
    part->resize(joints_);
    load_all(at, *part);
  }
  return Refusal::none;
}

}  // namespace saltus::robots::control
