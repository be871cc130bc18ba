/* A client game module that stands in front of the game's own: every call goes through, but the
 * eye of each world scene is put at the wanted view and the clock is read. A frame's time is the
 * time between two world scenes that follow each other: engine and renderer are unmodified.
 *
 * Numbers and structures are the engine's interface to client game modules (cg_public.h and
 * tr_types.h of ioquake3). Told by environment variables:
 *   FOLLOWSPOT_CGAME   the game's own module
 *   FOLLOWSPOT_VIEWS   lines "x y z yaw pitch"
 *   FOLLOWSPOT_FRAMES  counted frames of a view; FOLLOWSPOT_WARM before them
 *   FOLLOWSPOT_SHOTS   if there is one, each view's first counted frame is left as a picture
 *   FOLLOWSPOT_TIMES   written: "first SECONDS" (CLOCK_MONOTONIC when the first frame is done),
 *                      then a line of milliseconds for each view */
#include <dlfcn.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define EXPORT __attribute__((visibility("default")))
#define MAX_ARGUMENTS 15

enum { SEND_CONSOLE_COMMAND = 14, SEND_CLIENT_COMMAND = 16, RENDER_SCENE = 44 };
enum { NO_WORLD = 1 };          /* rdflags of scenes in menus and on the scoreboard */
enum { MAX_VIEWS = 64, MAX_FRAMES = 4096 };
enum { SETTLE = 60 };           /* scenes until snapshots flow and textures are all loaded */
enum { FIRST_TIME = 10000, STEP = 16 };  /* ms of game time: each run sees the same ones */

struct refdef {
    int x, y, width, height;
    float fov_x, fov_y;
    float eye[3], axis[3][3];   /* forward, left, up */
    int time, flags;
    uint8_t areas[32];
    char text[8][32];
};

typedef intptr_t (*engine_call)(intptr_t, ...);
static engine_call engine;
static intptr_t (*game_main)(intptr_t, ...);

static float views[MAX_VIEWS][5];
static double stamps[MAX_FRAMES + 1];
static int view_count, view, frame, scenes, frames, warm, shots;
static FILE *times;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + t.tv_nsec * 1e-9;
}

static int number_from(const char *name, int limit) {
    const char *text = getenv(name);
    int n = text ? atoi(text) : 0;
    return n < 1 ? 1 : n > limit ? limit : n;
}

static void open_files(void) {
    FILE *list = fopen(getenv("FOLLOWSPOT_VIEWS"), "r");
    times = fopen(getenv("FOLLOWSPOT_TIMES"), "w");
    if (!list || !times) { perror("proxy: FOLLOWSPOT_VIEWS, FOLLOWSPOT_TIMES"); exit(3); }
    float *v = views[0];
    while (view_count < MAX_VIEWS && fscanf(list, "%f%f%f%f%f", v, v + 1, v + 2, v + 3, v + 4) == 5)
        v = views[++view_count];
    fclose(list);
    frames = number_from("FOLLOWSPOT_FRAMES", MAX_FRAMES);
    warm = number_from("FOLLOWSPOT_WARM", MAX_FRAMES);
    shots = getenv("FOLLOWSPOT_SHOTS") != NULL;
}

static void move_player(const float *v) {   /* so that the server sends what is seen from there */
    char command[96];
    snprintf(command, sizeof command, "setviewpos %.0f %.0f %.0f %.0f", v[0], v[1], v[2] - 26, v[3]);
    engine(SEND_CLIENT_COMMAND, command);
}

static void take_picture(void) {
    char command[32];
    snprintf(command, sizeof command, "screenshot view%02d\n", view);
    engine(SEND_CONSOLE_COMMAND, command);
}

static void look_from(struct refdef *r, const float *v) {
    double yaw = v[3] * M_PI / 180, pitch = v[4] * M_PI / 180;
    double cy = cos(yaw), sy = sin(yaw), cp = cos(pitch), sp = sin(pitch);
    float axis[3][3] = {{cp * cy, cp * sy, -sp}, {-sy, cy, 0}, {sp * cy, sp * sy, cp}};
    for (int i = 0; i < 3; i++) {
        r->eye[i] = v[i];
        for (int j = 0; j < 3; j++) r->axis[i][j] = axis[i][j];
    }
    r->time = FIRST_TIME + (shots ? 0 : frame * STEP);
}

static void next_view(void) {
    for (int i = 0; i < frames; i++) fprintf(times, "%.4f ", (stamps[i + 1] - stamps[i]) * 1e3);
    fprintf(times, "\n");
    fflush(times);
    frame = 0;
    if (++view == view_count) engine(SEND_CONSOLE_COMMAND, "quit\n");
}

static void on_scene(struct refdef *r) {
    double t = now();
    scenes++;
    if (scenes == 2) { fprintf(times, "first %.6f\n", t); fflush(times); }
    if (view >= view_count) return;
    look_from(r, views[view]);
    if (scenes == 3) engine(SEND_CLIENT_COMMAND, "god");
    if (scenes == 4) engine(SEND_CLIENT_COMMAND, "noclip");
    if (scenes < SETTLE) return;
    if (frame == 0) move_player(views[view]);
    if (frame >= warm) stamps[frame - warm] = t;
    if (shots && frame == warm) take_picture();
    if (frame++ == warm + frames) next_view();
}

static intptr_t from_game(intptr_t call, ...) {
    intptr_t a[MAX_ARGUMENTS];
    va_list list;
    va_start(list, call);
    for (int i = 0; i < MAX_ARGUMENTS; i++) a[i] = va_arg(list, intptr_t);
    va_end(list);
    struct refdef scene;
    if (call == RENDER_SCENE) {
        scene = *(const struct refdef *)a[0];
        if (!(scene.flags & NO_WORLD)) on_scene(&scene);
        a[0] = (intptr_t)&scene;
    }
    return engine(call, a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8], a[9], a[10], a[11],
                  a[12], a[13], a[14]);
}

EXPORT void dllEntry(engine_call call) {
    engine = call;
    open_files();
    void *game = dlopen(getenv("FOLLOWSPOT_CGAME"), RTLD_NOW | RTLD_LOCAL);
    if (!game) { fprintf(stderr, "proxy: %s\n", dlerror()); exit(3); }
    void (*entry)(engine_call) = (void (*)(engine_call))dlsym(game, "dllEntry");
    game_main = (intptr_t (*)(intptr_t, ...))dlsym(game, "vmMain");
    entry(from_game);
}

EXPORT intptr_t vmMain(int call, int a, int b, int c, int d, int e, int f, int g, int h, int i,
                       int j, int k, int l) {
    return game_main(call, a, b, c, d, e, f, g, h, i, j, k, l);
}
