// The robot of link_controller: a cart with its own clock behind an unreliable connection. Every
// seventh measurement is lost, every fifth is one period late, and every ninth command is lost.
// Without a command the robot holds the last one; after five missing commands the input is zero.
//
//     link_robot PROGRAM      starts PROGRAM PORT, runs for 1.5 s, and prints the result
#include <sys/wait.h>

#include <cmath>
#include <string>

#include "link.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: link_robot CONTROLLER, a program to start\n");
    return 2;
  }
  UdpSocket link;
  const pid_t controller = fork();
  if (controller == 0) {
    const std::string port = std::to_string(link.port());
    execl(argv[1], argv[1], port.c_str(), nullptr);
    std::perror(argv[1]);
    std::_Exit(2);
  }

  constexpr int periods = 75;
  constexpr int patience = 5;  // periods without a command after which the input is zero
  IntegratorPlant cart = make_plant<2, 1>(Cart{}, runge_kutta4(), VectorXd{{0.3, 0.0}});
  VectorXd input = VectorXd::Zero(1);
  Command command;
  int lost = 0, late = 0, commands = 0, planned = 0, silent = 0, stops = 0;
  if (!link.receive(command, wall_clock() + 5.0)) {
    std::fprintf(stderr, "link_robot: no message from the controller for 5 s\n");
    return 1;
  }
  const int port = link.sender();
  const double begin = wall_clock();
  Measurement delayed;
  for (int k = 0; k < periods; ++k) {
    Measurement now{.number = k, .time = wall_clock() - begin};
    now.state[0] = cart.state()[0];
    now.state[1] = cart.state()[1];
    if (delayed.number > 0) link.send(delayed, port);
    delayed = {};
    if (k % 7 == 6) {
      ++lost;
    } else if (k % 5 == 4) {
      ++late;
      delayed = now;
    } else {
      link.send(now, port);
    }
    // Until the next period: accepts commands, except old and lost ones.
    bool is_new = false;
    for (Command one; link.receive(one, begin + period * (k + 1));) {
      if (one.number <= command.number || one.number % 9 == 8) continue;
      command = one;
      is_new = true;
      input[0] = command.input;
      planned += command.provenance == static_cast<int>(Provenance::fallback) ? 0 : 1;
      ++commands;
    }
    silent = is_new ? 0 : silent + 1;
    if (silent == patience) {
      input.setZero();
      ++stops;
    }
    if (!cart.advance(input, period)) return 1;
  }
  link.send(Measurement{.number = -1}, port);
  int status = 0;
  waitpid(controller, &status, 0);
  const double left = std::abs(cart.state()[0]);
  std::printf(
      "robot: %d measurements lost, %d late; %d commands, %d from a plan; stopped %d times\n", lost,
      late, commands, planned, stops);
  std::printf("from 30 cm to less than 5 cm in %.1f s: %s\n", periods * period,
              left < 0.05 ? "yes" : "no");
  return status == 0 && left < 0.15 ? 0 : 1;  // a loaded machine is late more often
}
