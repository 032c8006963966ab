/* conserva-mumps: one rank of the distributed direct solver. MPI starts one process of this program per rank; rank 0 is connected by a
 * Unix socket to the program `conserva`, whose linear systems all ranks factorize and solve with MUMPS.
 *
 * Why a program of its own, and why in C:
 * - `conserva` links neither MPI nor MUMPS, and contains no foreign function: a machine without them builds and runs it unchanged.
 * - The structure of MUMPS and the handles of MPI differ between versions and vendors. Their own headers describe them to the compiler;
 *   copies of these definitions in another language would have to be kept in step by hand, and every access would be unsafe.
 * - A fault of a rank ends this process and not the run: `conserva` reads the end of the connection and writes its checkpoint.
 *
 * Protocol: messages of `HEAD` integers of 64 bits in the byte order of the machine, then data. Both ends are on one machine.
 *   greeting   MAGIC, ranks, and the version of MUMPS as VERSION_LENGTH bytes
 *   STRUCTURE  id, symmetry, n, nnz; rows, columns (int32, from 1). Symmetric matrices: lower triangle. No answer.
 *   FACTORIZE  id; nnz values. Answer: status, second number of the status, negative pivots, null pivots; one double per rank: megabytes.
 *   SOLVE      id, right sides; n values each. Answer: status; the solutions if the status is 0.
 *   FREE       id. No answer.
 *   FINISH     no answer; the end of the connection has the same meaning.
 */

#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <dmumps_c.h>
#include <mpi.h>

#define HEAD 8
#define MAGIC INT64_C(0x31304d554d4f43)
#define VERSION_LENGTH 32
#define USE_COMM_WORLD (-987654)
#define MOST_TRIES 6

enum command { STRUCTURE = 1, FACTORIZE = 2, SOLVE = 3, FREE = 4, FINISH = 5 };
enum job { INITIALIZE = -1, TERMINATE = -2, ANALYSE = 1, FACTORS = 2, SUBSTITUTE = 3 };

/* Parameters with the numbers of the manual, which count from 1. */
#define ICNTL(number) icntl[(number) - 1]
#define INFO(number) info[(number) - 1]
#define INFOG(number) infog[(number) - 1]

/* Statuses besides those of MUMPS (INFOG(1)), which are above -1000. */
#define UNKNOWN_MATRIX (-1001)
#define OUT_OF_MEMORY (-13)

/* A matrix; rows, columns and values are on rank 0 only. */
struct matrix {
    int64_t id;
    int is_analysed;
    int32_t *rows, *columns;
    double *values;
    DMUMPS_STRUC_C mumps;
    struct matrix *next;
};

static struct matrix *matrices = NULL;
static int rank = 0, ranks = 1;

/* Socket of rank 0. */
static int connection = -1;

/* Reads `size` bytes; returns 0 at the end of the connection. */
static int receive(void *data, size_t size) {
    char *at = data;
    while (size > 0) {
        ssize_t count = read(connection, at, size);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return 0;
        at += count;
        size -= (size_t)count;
    }
    return 1;
}

/* Writes `size` bytes; returns 0 if the connection has ended. */
static int deliver(const void *data, size_t size) {
    const char *at = data;
    while (size > 0) {
        ssize_t count = write(connection, at, size);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return 0;
        at += count;
        size -= (size_t)count;
    }
    return 1;
}

/* Connects rank 0 with the program `conserva`, which listens at a path; returns 0 on failure. */
static int connect_to(const char *path) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path) return 0;
    strcpy(address.sun_path, path);
    connection = socket(AF_UNIX, SOCK_STREAM, 0);
    return connection >= 0 && connect(connection, (struct sockaddr *)&address, sizeof address) == 0;
}

/* Distributes the head of a message from rank 0. The other ranks sleep while they wait: a blocking broadcast would occupy a core while
 * rank 0 assembles the next matrix. */
static void broadcast(int64_t head[HEAD]) {
    MPI_Request request;
    MPI_Ibcast(head, HEAD, MPI_INT64_T, 0, MPI_COMM_WORLD, &request);
    long pause = 20000;
    for (int is_done = 0;;) {
        MPI_Test(&request, &is_done, MPI_STATUS_IGNORE);
        if (is_done) return;
        struct timespec time = {0, pause};
        nanosleep(&time, NULL);
        if (pause < 2000000) pause += pause / 4;
    }
}

static void release(struct matrix *matrix) {
    matrix->mumps.job = TERMINATE;
    dmumps_c(&matrix->mumps);
    free(matrix->rows);
    free(matrix->columns);
    free(matrix->values);
    free(matrix);
}

/* Takes a matrix out of the list; NULL if there is none of this number. */
static struct matrix *take(int64_t id) {
    for (struct matrix **link = &matrices; *link; link = &(*link)->next) {
        if ((*link)->id == id) {
            struct matrix *found = *link;
            *link = found->next;
            return found;
        }
    }
    return NULL;
}

static struct matrix *find(int64_t id) {
    struct matrix *matrix = matrices;
    while (matrix && matrix->id != id) matrix = matrix->next;
    return matrix;
}

static void set_parameters(DMUMPS_STRUC_C *mumps, int is_symmetric) {
    for (int stream = 1; stream <= 4; stream++) mumps->ICNTL(stream) = 0;
    mumps->ICNTL(1) = mumps->ICNTL(2) = mumps->ICNTL(3) = -1;
    mumps->ICNTL(7) = 5;                /* METIS, as the direct solver */
    mumps->ICNTL(10) = 0;               /* `conserva` refines on its own matrix */
    mumps->ICNTL(13) = is_symmetric;    /* without ScaLAPACK at the root, which would not count negative pivots */
    mumps->ICNTL(14) = 30;              /* percent of working space beyond the estimate */
    mumps->ICNTL(18) = 0;               /* the matrix is on rank 0 */
    mumps->ICNTL(24) = 1;               /* null pivots are counted */
    mumps->ICNTL(28) = 1;               /* sequential analysis: it depends on the matrix only */
}

/* Takes the structure of a matrix; it replaces an earlier one of this number. */
static int take_structure(const int64_t head[HEAD]) {
    struct matrix *earlier = take(head[1]);
    if (earlier) release(earlier);
    struct matrix *matrix = calloc(1, sizeof *matrix);
    int is_there = matrix != NULL;
    MPI_Allreduce(MPI_IN_PLACE, &is_there, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    if (!is_there) return 0;
    matrix->id = head[1];
    DMUMPS_STRUC_C *mumps = &matrix->mumps;
    mumps->comm_fortran = USE_COMM_WORLD;
    mumps->par = 1;
    mumps->sym = head[2] ? 2 : 0;
    mumps->job = INITIALIZE;
    dmumps_c(mumps);
    set_parameters(mumps, head[2] != 0);
    matrix->next = matrices;
    matrices = matrix;
    if (rank > 0) return 1;
    size_t count = (size_t)head[4];
    matrix->rows = malloc(count * sizeof(int32_t));
    matrix->columns = malloc(count * sizeof(int32_t));
    matrix->values = malloc(count * sizeof(double));
    if (!matrix->rows || !matrix->columns || !matrix->values) return 0;
    mumps->n = (MUMPS_INT)head[3];
    mumps->nnz = head[4];
    mumps->irn = matrix->rows;
    mumps->jcn = matrix->columns;
    mumps->a = matrix->values;
    return receive(matrix->rows, count * sizeof(int32_t)) && receive(matrix->columns, count * sizeof(int32_t));
}

/* True if the factorization may succeed with more working space. */
static int lacks_space(int status) {
    return status == -8 || status == -9 || status == -11 || status == -12 || status == -14 || status == -15 || status == -17 || status == -20;
}

static int factorize(const int64_t head[HEAD]) {
    struct matrix *matrix = find(head[1]);
    int64_t answer[HEAD] = {matrix ? 0 : UNKNOWN_MATRIX};
    double own = 0.0, *all = rank == 0 ? calloc((size_t)ranks, sizeof(double)) : NULL;
    if (rank == 0 && !all) return 0;
    if (matrix) {
        DMUMPS_STRUC_C *mumps = &matrix->mumps;
        if (rank == 0 && !receive(matrix->values, (size_t)mumps->nnz * sizeof(double))) {
            free(all);
            return 0;
        }
        if (!matrix->is_analysed) {
            mumps->job = ANALYSE;
            dmumps_c(mumps);
            matrix->is_analysed = mumps->INFOG(1) >= 0;
        }
        for (int tries = 0; matrix->is_analysed && tries < MOST_TRIES; tries++) {
            mumps->job = FACTORS;
            dmumps_c(mumps);
            if (!lacks_space(mumps->INFOG(1))) break;
            mumps->ICNTL(14) *= 2;
        }
        answer[0] = mumps->INFOG(1) < 0 ? mumps->INFOG(1) : 0;
        answer[1] = mumps->INFOG(2);
        answer[2] = mumps->INFOG(12);
        answer[3] = mumps->INFOG(28);
        own = mumps->INFO(22);
    }
    MPI_Gather(&own, 1, MPI_DOUBLE, all, 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
    int is_told = rank > 0 || (deliver(answer, sizeof answer) && deliver(all, (size_t)ranks * sizeof(double)));
    free(all);
    return is_told;
}

static int solve(const int64_t head[HEAD]) {
    struct matrix *matrix = find(head[1]);
    int64_t answer[HEAD] = {matrix ? 0 : UNKNOWN_MATRIX};
    double *rights = NULL;
    size_t size = 0;
    if (matrix) {
        DMUMPS_STRUC_C *mumps = &matrix->mumps;
        if (rank == 0) {
            size = (size_t)mumps->n * (size_t)head[2] * sizeof(double);
            rights = malloc(size);
            if (!rights || !receive(rights, size)) {
                free(rights);
                return 0;
            }
            mumps->rhs = rights;
            mumps->lrhs = mumps->n;
            mumps->nrhs = (MUMPS_INT)head[2];
        }
        mumps->job = SUBSTITUTE;
        dmumps_c(mumps);
        answer[0] = mumps->INFOG(1) < 0 ? mumps->INFOG(1) : 0;
        answer[1] = mumps->INFOG(2);
    }
    int is_told = rank > 0 || (deliver(answer, sizeof answer) && (answer[0] != 0 || deliver(rights, size)));
    free(rights);
    return is_told;
}

/* Reads the head of the next message; the end of the connection and a head with impossible sizes are FINISH. */
static void next_message(int64_t head[HEAD]) {
    int is_whole = receive(head, HEAD * sizeof(int64_t));
    int is_sound = is_whole && head[0] >= STRUCTURE && head[0] <= FINISH;
    if (is_sound && head[0] == STRUCTURE) {
        is_sound = head[3] > 0 && head[3] <= INT32_MAX && head[4] > 0 && head[4] <= INT64_MAX / 16;
    }
    if (is_sound && head[0] == SOLVE) is_sound = head[2] > 0 && head[2] <= INT32_MAX;
    if (!is_sound) head[0] = FINISH;
}

/* Serves until FINISH. If rank 0 cannot go on in the middle of a message, all ranks end at once. */
static void serve(void) {
    for (;;) {
        int64_t head[HEAD] = {FINISH};
        if (rank == 0) next_message(head);
        broadcast(head);
        int is_fine = 1;
        switch (head[0]) {
        case STRUCTURE: is_fine = take_structure(head); break;
        case FACTORIZE: is_fine = factorize(head); break;
        case SOLVE: is_fine = solve(head); break;
        case FREE: {
            struct matrix *matrix = take(head[1]);
            if (matrix) release(matrix);
            break;
        }
        default: return;
        }
        if (!is_fine) MPI_Abort(MPI_COMM_WORLD, 1);
    }
}

int main(int count, char **arguments) {
    /* Signals that end a run are for `conserva`, which writes its checkpoint; a broken connection is found where it is written to. */
    const int ignored[] = {SIGINT, SIGUSR1, SIGXCPU, SIGPIPE};
    for (size_t k = 0; k < sizeof ignored / sizeof *ignored; k++) signal(ignored[k], SIG_IGN);
    MPI_Init(&count, &arguments);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    /* One thread per rank; OpenBLAS would take all cores in each. */
    void (*set_threads)(int) = NULL;
    *(void **)&set_threads = dlsym(RTLD_DEFAULT, "openblas_set_num_threads");
    if (set_threads) set_threads(1);
    if (rank == 0) {
        if (count < 2 || !connect_to(arguments[1])) {
            fprintf(stderr, "conserva-mumps: started by `conserva run --solver mumps`, whose connection is not found on this machine\n");
            MPI_Abort(MPI_COMM_WORLD, 1);
        }
        int64_t head[HEAD] = {MAGIC, ranks};
        char version[VERSION_LENGTH] = {0};
        strncpy(version, MUMPS_VERSION, VERSION_LENGTH - 1);
        deliver(head, sizeof head);
        deliver(version, sizeof version);
    }
    serve();
    while (matrices) release(take(matrices->id));
    MPI_Finalize();
    return 0;
}
