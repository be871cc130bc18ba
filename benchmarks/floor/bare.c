/* The floor: the GL calls of one frame and nothing else, timed. The calls are in calls.h, which
 * floor.py writes, and their data in a file; both come from what followspot itself called.
 * bare DATA FRAMES WARM PICTURE: prints the milliseconds of each counted frame, the GPU drained
 * after it, and writes the picture as raw RGB bytes, bottom row first. */
#define GL_GLEXT_PROTOTYPES
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>

static const char *data;

static void stop(const char *what) {
    fprintf(stderr, "bare: %s\n", what);
    exit(1);
}

/* Objects get the names that followspot's had: the same driver gives them in the same order. */
static void same(GLuint made, GLuint wanted) {
    if (made != wanted) stop("an object has another name than when the calls were recorded");
}
#define MAKE(create, wanted) do { GLuint made; create(1, &made); same(made, wanted); } while (0)
#define SAME(call, wanted) same(call, wanted)

static void source(GLuint shader, const char *text) { glShaderSource(shader, 1, &text, NULL); }

#include "calls.h" /* setup(), frame(), PICTURE_* */

static void create_context(void) {
    EGLDisplay display =
        eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    if (!eglInitialize(display, NULL, NULL)) stop("EGL without a surface is not to be had");
    eglBindAPI(EGL_OPENGL_API);
    const EGLint wanted[] = {
        EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3,
        EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
        stop("no OpenGL 3.3 core context");
    if (strcmp((const char *)glGetString(GL_RENDERER), GL_RENDERER_RECORDED))
        stop("this is not the renderer that the calls were recorded on");
}

static void read_data(const char *path) {
    struct stat about;
    int file = open(path, O_RDONLY);
    if (file < 0 || fstat(file, &about)) stop("no data");
    data = mmap(NULL, about.st_size, PROT_READ, MAP_PRIVATE | MAP_POPULATE, file, 0);
    if (data == MAP_FAILED) stop("no memory");
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1e3 + t.tv_nsec * 1e-6;
}

static void write_picture(const char *path) {
    size_t size = (size_t)PICTURE_WIDTH * PICTURE_HEIGHT * 3;
    char *pixels = malloc(size);
    FILE *file = fopen(path, "wb");
    if (!pixels || !file) stop("no picture");
    glBindFramebuffer(GL_FRAMEBUFFER, PICTURE_FRAMEBUFFER);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, PICTURE_WIDTH, PICTURE_HEIGHT, GL_RGB, GL_UNSIGNED_BYTE, pixels);
    fwrite(pixels, 1, size, file);
    fclose(file);
}

int main(int count, char **words) {
    if (count != 5) stop("expected DATA FRAMES WARM PICTURE");
    int frames = atoi(words[2]), warm = atoi(words[3]);
    create_context();
    read_data(words[1]);
    setup();
    for (int i = -warm; i < frames; i++) {
        double start = now();
        frame();
        glFinish();
        if (i >= 0) printf("%.4f\n", now() - start);
    }
    if (glGetError() != GL_NO_ERROR) stop("a call failed");
    write_picture(words[4]);
}
