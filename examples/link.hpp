// What the robot and the controller of link_robot.cpp and link_controller.cpp have in common: the
// model, two messages, and a UDP socket.
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include <netinet/in.h>
#include <saltus/saltus.hpp>

using namespace saltus;

constexpr double period = 0.02;  // s

struct Cart {  // x = (position m, speed m/s), u = force per mass, m/s^2
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 0.2 * x[1]};
  }
};

// Plain bytes, as both processes run on one machine; between machines agree on an order of bytes.
struct Measurement {
  std::uint32_t kind = 0x4d454131;  // what is not this is not ours
  std::int32_t number = 0;          // of the period; negative: the robot is done
  double time = 0.0;                // on the robot's clock, when it was measured, s
  double state[2] = {0.0, 0.0};
};
struct Command {
  std::uint32_t kind = 0x434d4431;
  std::int32_t number = 0;      // of the period for which it is
  std::int32_t provenance = 0;  // of the input
  double input = 0.0;
};

inline double wall_clock() {  // s; of nobody else
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// On the loopback interface, where the system finds a free port.
class UdpSocket {
 public:
  UdpSocket() : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in any = address(0);
    if (socket_ < 0 || bind(socket_, reinterpret_cast<sockaddr*>(&any), sizeof any) != 0) {
      std::perror("socket");
      std::exit(2);
    }
  }
  ~UdpSocket() { close(socket_); }
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  int port() const {
    sockaddr_in own{};
    socklen_t size = sizeof own;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &size);
    return ntohs(own.sin_port);
  }
  // What cannot be sent is lost, as on any network.
  template <class Message>
  void send(const Message& message, int port) const {
    sockaddr_in there = address(port);
    sendto(socket_, &message, sizeof message, MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&there),
           sizeof there);
  }
  int sender() const { return sender_; }  // port of the last message received
  // Waits until `until` on wall_clock() at most. What is no such message is dropped.
  template <class Message>
  bool receive(Message& message, double until) {
    for (;;) {
      pollfd wanted{socket_, POLLIN, 0};
      const double left = until - wall_clock();
      const timespec rest{0, left > 0.0 ? static_cast<long>(1e9 * (left < 0.9 ? left : 0.9)) : 0};
      if (ppoll(&wanted, 1, &rest, nullptr) <= 0) {
        if (wall_clock() < until) continue;
        return false;
      }
      Message one;
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t bytes = recvfrom(socket_, &one, sizeof one, MSG_DONTWAIT | MSG_TRUNC,
                                     reinterpret_cast<sockaddr*>(&from), &size);
      if (bytes == sizeof one && one.kind == Message{}.kind) {
        sender_ = ntohs(from.sin_port);
        message = one;
        return true;
      }
    }
  }

 private:
  static sockaddr_in address(int port) {
    sockaddr_in one{};
    one.sin_family = AF_INET;
    one.sin_port = htons(static_cast<std::uint16_t>(port));
    one.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return one;
  }
  int socket_, sender_ = 0;
};
