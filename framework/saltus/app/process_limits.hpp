// Handling of system limits on the process.
#pragma once

namespace saltus {

/// Sets the signal handling of the process. A file size limit (SIGXFSZ) becomes a write error.
/// SIGINT and SIGTERM are neither ignored nor blocked, whatever the parent process set. If memory
/// runs out where no handler can be reached (a destructor, a thread), the process ends with one
/// sentence and status 2.
///
/// Programs call it first. On Linux, linking it also restarts the program with
/// OPENBLAS_NUM_THREADS=1 if its memory or number of processes is limited. Otherwise the threads
/// that OpenBLAS starts before main() request memory in an endless loop, or end the process if no
/// threads are available.
void prepare_process();

}  // namespace saltus
