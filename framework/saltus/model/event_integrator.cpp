#include "saltus/model/integrator.hpp"

namespace saltus {

const char* describe(EventKind kind) {
  switch (kind) {
    case EventKind::crosses:
      return "crosses";
    case EventKind::jumps:
      return "jumps";
    case EventKind::slides:
      return "slides";
    case EventKind::leaves:
      return "leaves";
  }
  return "unknown kind of event";
}

}  // namespace saltus
