/* A program that is not linked with the driver: it loads libgicube.so, opens a board by it, and unloads it again. */
#include <dlfcn.h>
#include <gicube/c_api.h>
#include <stdio.h>
#include <string.h>

/* ISO C has no conversion from a data pointer to a function pointer; POSIX says that it works. */
static int look_up(void* library, const char* name, void* function) {
  void* found = dlsym(library, name);
  if (found == NULL) {
    fprintf(stderr, "%s\n", dlerror());
    return 0;
  }
  memcpy(function, &found, sizeof found);
  return 1;
}

static int use(const char* path) {
  void* library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (library == NULL) {
    fprintf(stderr, "%s\n", dlerror());
    return 1;
  }
  uint32_t (*version)(void);
  gicube_status (*open_board)(const char*, const gicube_open_options*, gicube_board**);
  gicube_status (*info_init)(gicube_board_info*, size_t);
  gicube_status (*get_info)(gicube_board*, gicube_board_info*);
  void (*close_board)(gicube_board*);
  const char* (*last_error)(void);
  if (!look_up(library, "gicube_version", &version) || !look_up(library, "gicube_open", &open_board) ||
      !look_up(library, "gicube_board_info_init", &info_init) || !look_up(library, "gicube_get_info", &get_info) ||
      !look_up(library, "gicube_close", &close_board) || !look_up(library, "gicube_last_error", &last_error)) {
    return 1;
  }
  gicube_board* board = NULL;
  if (open_board("emu:?set=asic.processors=3", NULL, &board) != GICUBE_OK) {
    fprintf(stderr, "open: %s\n", last_error());
    return 1;
  }
  gicube_board_info info;
  if (info_init(&info, sizeof info) != GICUBE_OK || get_info(board, &info) != GICUBE_OK) return 1;
  printf("version %06x, %d processors\n", (unsigned)version(), (int)info.processors);
  close_board(board);

  /* Errors come as statuses through the library's border, and never as exceptions. */
  if (open_board("emu:?bus=isa", NULL, &board) != GICUBE_BAD_ARGUMENT || board != NULL) return 1;
  if (strstr(last_error(), "bus") == NULL) return 1;
  return dlclose(library);
}

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  for (int i = 0; i < 2; ++i) {
    if (use(argv[1]) != 0) return 1;
  }
  return 0;
}
