// What a program does about the limits under which the system runs it.
#pragma once

namespace saltus {

/// Sets the signals of the process so that faults end in a sentence and every interrupt works: a
/// file that may grow no further (SIGXFSZ) is an error of the write, and SIGINT and SIGTERM are
/// neither ignored nor blocked, whatever the caller left. Memory that runs out where no handler can
/// be reached (a destructor, a thread) ends the process with one sentence and status 2.
///
/// Programs call it first. On Linux, linking it also starts the program again with
/// OPENBLAS_NUM_THREADS=1 where its memory or its processes are limited: the threads that OpenBLAS
/// starts before main() ask for memory in an endless loop, or end the process if there are none.
void prepare_process();

}  // namespace saltus
