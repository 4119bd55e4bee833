/* C interface of a plugin: create a controller by name, tick it, read its input and its plan.
 *
 * A plugin is a shared library with controllers that its author registers in C++
 * (saltus/c/register_controller.hpp). A host loads the plugin, for example by dlopen(), and finds
 * these functions in it. The host needs this header only, and no C++.
 *
 * Units are those of the problem; times are in seconds. Arrays are dense and row-major. No
 * exception leaves these functions. saltus_prepare(), saltus_feedback() and saltus_read_piece() do
 * not allocate memory if the controller's solver does not.
 *
 * Use a controller from one thread at a time. Several controllers can run in several threads.
 * Destroy all controllers before you unload their plugin. */
#ifndef SALTUS_C_H
#define SALTUS_C_H

#ifdef __cplusplus
extern "C" {
#endif

/** Version of this interface. It changes if a host for the former version would fail. */
#define SALTUS_INTERFACE_VERSION 1

/** Status of a call. saltus_error() has a sentence about every status except SALTUS_OK. */
typedef enum saltus_status {
  SALTUS_OK = 0,             /**< done */
  SALTUS_BAD_ARGUMENT = 1,   /**< a null pointer, or a wrong size */
  SALTUS_UNKNOWN_NAME = 2,   /**< no controller with this name is registered */
  SALTUS_BAD_DEFINITION = 3, /**< invalid problem, or an unknown name or wrong size of data */
  SALTUS_NO_PLAN = 4,        /**< no tick yet, or the controller was changed since */
  SALTUS_FAILURE = 5         /**< any other exception, for example: no memory */
} saltus_status;

/** Source of the input of a tick. */
typedef enum saltus_provenance {
  SALTUS_OPTIMAL = 0,  /**< plan of this tick, an optimum */
  SALTUS_FEASIBLE = 1, /**< plan of this tick, satisfies all rows and bounds */
  SALTUS_SHIFTED = 2,  /**< plan of an earlier tick */
  SALTUS_FALLBACK = 3, /**< the fallback of the controller */
  SALTUS_STEP = 4      /**< plan of this tick, neither optimal nor feasible yet */
} saltus_provenance;

/** A controller. */
typedef struct saltus_controller saltus_controller;

/** Sizes that the host needs for its arrays. They do not change. */
typedef struct saltus_sizes {
  int states;      /**< entries of the measured state */
  int inputs;      /**< entries of an input in the first phase */
  int plan_states; /**< columns of the states of a plan: the largest phase */
  int plan_inputs; /**< columns of the inputs of a plan: the largest phase */
  double period;   /**< control period in seconds */
} saltus_sizes;

/** Result of a tick. */
typedef struct saltus_tick {
  double time;                  /**< start of the tick in seconds */
  saltus_provenance provenance; /**< source of the input */
  int pieces;                   /**< constant pieces of the input, at least one */
  int iterations;               /**< iterations of the solver */
  double objective;             /**< cost of the plan; infinite without a plan of this tick */
  double kkt;                   /**< scaled residual of the plan, or infinite */
  double violation;             /**< largest scaled violation of the plan, or infinite */
  double preparation;           /**< wall-clock seconds of saltus_prepare() */
  double feedback;              /**< wall-clock seconds from the measurement to the input */
  double check;                 /**< wall-clock seconds of the check after the input */
  const char* solve;            /**< result of the solve as a phrase; static memory */
} saltus_tick;

/** Called with the context of saltus_on_input() and the tick. */
typedef void (*saltus_input_callback)(void* context, const saltus_tick* tick);

/** SALTUS_INTERFACE_VERSION of the plugin. Compare it with the one of this header first. */
int saltus_interface_version(void);
/** Version of Saltus in the plugin, for example "0.3.0". */
const char* saltus_version(void);
/** Number of registered controllers. */
int saltus_controllers(void);
/** Name of controller i, or NULL if there is none. */
const char* saltus_controller_name(int i);

/** Creates a controller. After a failure *controller is a handle that only has an error text, or
 * NULL without memory. Destroy it in both cases. Allocates. */
saltus_status saltus_create(const char* name, saltus_controller** controller);
/** Destroys a controller. NULL has no effect. */
void saltus_destroy(saltus_controller* controller);
/** Error text of the last call with this controller, empty after SALTUS_OK. At most 1023
 * characters, valid until the next call. */
const char* saltus_error(const saltus_controller* controller);
/** Sizes of the controller. */
saltus_status saltus_read_sizes(saltus_controller* controller, saltus_sizes* sizes);

/** Sets data of the problem before a tick, by name. Matrices are row-major. With NaN the next tick
 * uses the previous plan. */
saltus_status saltus_set_data(saltus_controller* controller, const char* name, const double* values,
                              int count);
/** Moves an event of the schedule to this time. */
saltus_status saltus_retime(saltus_controller* controller, const char* event, double time);
/** Sets the input before the first tick, if the problem reads it. */
saltus_status saltus_set_previous_input(saltus_controller* controller, const double* input,
                                        int count);
/** Sets a function that saltus_feedback() calls as soon as the input is known, before it checks
 * the plan. The function may call saltus_read_piece() only. NULL: no function. It is not called if
 * the plugin sets ControllerOptions::send itself. */
saltus_status saltus_on_input(saltus_controller* controller, saltus_input_callback callback,
                              void* context);

/** Does all work of the tick at this time that does not need the measurement. */
saltus_status saltus_prepare(saltus_controller* controller, double time);
/** Runs the tick at the prepared time, or one period after the last tick. state: the measured
 * state; NULL if the measurement was lost. `tick` may be NULL. Every tick has an input. Also after
 * SALTUS_BAD_ARGUMENT for a wrong count, the tick ran as without a measurement. */
saltus_status saltus_feedback(saltus_controller* controller, const double* state, int count,
                              saltus_tick* tick);
/** Reads piece i of the input of the last tick, constant during [*start, *start + *length). Writes
 * its entries to input[0 ... *count - 1]; capacity: number of entries of the array. */
saltus_status saltus_read_piece(saltus_controller* controller, int i, double* start, double* length,
                                double* input, int capacity, int* count);

/** Reads the plan of the last tick, after the tick and before the next change of the controller.
 * If the tick made no plan, it is the source of its input. A row is a node: times[row],
 * phases[row], states[row * plan_states + i], inputs[row * plan_inputs + i]. An event has two rows,
 * the first with the values before it. Entries that a phase does not have are NaN. `phases`,
 * `states` and `inputs` may be NULL. *rows: number of rows; if it exceeds the capacity, nothing
 * else is written and the status is SALTUS_BAD_ARGUMENT. Allocates: call it outside the control
 * loop. */
saltus_status saltus_read_plan(saltus_controller* controller, double* times, int* phases,
                               double* states, double* inputs, int capacity, int* rows);

#ifdef __cplusplus
}
#endif

#endif
