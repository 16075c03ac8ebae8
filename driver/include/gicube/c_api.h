/* The driver for C, and for all that calls C: what gicube/board.h has, by its rules and in its units.
 *
 *   gicube_board* board = NULL;
 *   if (gicube_open("emu:", NULL, &board) != GICUBE_OK) {
 *     fprintf(stderr, "%s\n", gicube_last_error());
 *   }
 *
 * Every call returns a status. None throws, ends the process or writes to a NULL: an argument that is NULL or out of
 * its range is GICUBE_BAD_ARGUMENT with its name in gicube_last_error(). Several threads may use a board; their calls
 * take turns, and gicube_close() must be the last one. Times are picoseconds of simulated time since gicube_open().
 * Counts of arrays must be what the call moves, so that no buffer is ever taken for a larger one. */
#ifndef GICUBE_C_API_H
#define GICUBE_C_API_H

#include "gicube/c_types.h"
#define GICUBE_C_INTERFACE
#include "gicube/export.h"
#undef GICUBE_C_INTERFACE

/* NOLINTBEGIN(modernize-use-using, readability-identifier-naming): C, and its names */

#ifdef __cplusplus
extern "C" {
#endif

typedef struct gicube_board gicube_board;
typedef struct gicube_counter_list gicube_counter_list;
typedef struct gicube_found_list gicube_found_list;
typedef struct gicube_pending gicube_pending;

/* Parts done and parts in all of a long call, on the calling thread. Nonzero ends the call with GICUBE_STOPPED. */
typedef int (*gicube_progress)(void* user, uint32_t done, uint32_t all);
/* Scatters one ray. Nonzero ends the call that needed it with GICUBE_STOPPED. It may ask its board for nothing but
 * gicube_now() and gicube_get_info(). */
typedef int (*gicube_scattering_routine)(void* user, const gicube_scatter_event* event, gicube_scatter_answer* answer);

/* A deadline that never passes. */
#define GICUBE_NO_DEADLINE UINT64_MAX

/* The library's version, as 0x00MMmmpp. */
GICUBE_API uint32_t gicube_version(void);
/* "GICUBE_BAD_ARGUMENT" and so on; "?" if it is no status. */
GICUBE_API const char* gicube_status_name(gicube_status status);
/* The words of this thread's last failure; empty before the first one. Valid until the thread's next call. */
GICUBE_API const char* gicube_last_error(void);
/* The name of the argument or field that was wrong, as "view.width"; empty if the last failure was not
 * GICUBE_BAD_ARGUMENT. */
GICUBE_API const char* gicube_last_error_field(void);
/* Why the board was lost: GICUBE_LOSS_..., of this thread's last failure. */
GICUBE_API int32_t gicube_last_loss(void);

/* Set all defaults, and `size` to sizeof of the caller's record: gicube_view_init(&view, sizeof view). */
GICUBE_API gicube_status gicube_open_options_init(gicube_open_options* options, size_t size);
GICUBE_API gicube_status gicube_found_board_init(gicube_found_board* found, size_t size);
GICUBE_API gicube_status gicube_board_info_init(gicube_board_info* info, size_t size);
GICUBE_API gicube_status gicube_volume_init(gicube_volume* volume, size_t size);
GICUBE_API gicube_status gicube_shading_init(gicube_shading* shading, size_t size);
GICUBE_API gicube_status gicube_material_init(gicube_material* material, size_t size);
GICUBE_API gicube_status gicube_illumination_init(gicube_illumination* settings, size_t size);
GICUBE_API gicube_status gicube_lighting_report_init(gicube_lighting_report* report, size_t size);
GICUBE_API gicube_status gicube_view_init(gicube_view* view, size_t size);
GICUBE_API gicube_status gicube_ray_request_init(gicube_ray_request* request, size_t size);
GICUBE_API gicube_status gicube_pair_request_init(gicube_pair_request* request, size_t size);
GICUBE_API gicube_status gicube_batch_report_init(gicube_batch_report* report, size_t size);

/* The boards that a program could open, as gicube::enumerate(): the list of this moment, which the caller frees. */
GICUBE_API gicube_status gicube_enumerate(gicube_found_list** list);
GICUBE_API void gicube_found_free(gicube_found_list* list);
GICUBE_API size_t gicube_found_count(const gicube_found_list* list);
GICUBE_API gicube_status gicube_found_at(const gicube_found_list* list, size_t index, gicube_found_board* found);

/* Opens a board and resets it; options may be NULL. *board is NULL unless it succeeds. */
GICUBE_API gicube_status gicube_open(const char* uri, const gicube_open_options* options, gicube_board** board);
/* After GICUBE_DEVICE_LOST or GICUBE_TIMED_OUT: connects again by the same URI and options, and continues with
 * the session or on a new board, as Board::reopen(). reopened may be NULL. If it fails the board is still lost. */
GICUBE_API gicube_status gicube_reopen(gicube_board* board, gicube_reopened* reopened);
/* Saves the board and the driver's state to a file, as Board::save(). GICUBE_INTERNAL: it can't be
 * written. */
GICUBE_API gicube_status gicube_save(gicube_board* board, const char* file);
/* Continues from such a file, as Board::restore(). After any failure nothing has changed. The framebuffer is as it was
 * saved, but its size is known here only after the next picture. */
GICUBE_API gicube_status gicube_restore(gicube_board* board, const char* file);
/* Ends the session. NULL is no board and no error. */
GICUBE_API void gicube_close(gicube_board* board);
GICUBE_API gicube_status gicube_get_info(gicube_board* board, gicube_board_info* info);

/* Volumes. progress may be NULL. */
GICUBE_API gicube_status gicube_load_volume(gicube_board* board, const gicube_volume* volume, gicube_progress progress,
                                            void* user);
GICUBE_API gicube_status gicube_value_range(gicube_board* board, double* low, double* high);
/* The values of a box, x fastest; count is the box's number of voxels. */
GICUBE_API gicube_status gicube_read_volume(gicube_board* board, const gicube_box* box, float* values, size_t count);
GICUBE_API gicube_status gicube_write_volume(gicube_board* board, const gicube_box* box, const float* values,
                                             size_t count);
/* Has the board read its volume back. *damaged_count is how many blocks differ from what was loaded; the first
 * `capacity` of their numbers, ascending, go to `damaged`, which may be NULL if that is 0. */
GICUBE_API gicube_status gicube_verify_volume(gicube_board* board, size_t* damaged, size_t capacity,
                                              size_t* damaged_count);

/* How things look. */
GICUBE_API gicube_status gicube_set_transfer_function(gicube_board* board, int32_t tag,
                                                      const gicube_colour_point* colours, size_t colour_count,
                                                      const gicube_opacity_point* opacities, size_t opacity_count);
GICUBE_API gicube_status gicube_set_shading(gicube_board* board, const gicube_shading* shading);
GICUBE_API gicube_status gicube_set_material(gicube_board* board, int32_t tag, const gicube_material* material);
/* A NULL routine takes it back. `user` must live as long as the routine is set. */
GICUBE_API gicube_status gicube_set_scattering_routine(gicube_board* board, gicube_scattering_routine routine,
                                                       void* user, uint64_t time_per_ray_ps);
/* 3 doubles per code. */
GICUBE_API gicube_status gicube_set_gradient_codebook(gicube_board* board, const double* codebook, size_t codes);
/* How many blocks along each axis. */
GICUBE_API gicube_status gicube_get_blocks(gicube_board* board, int32_t blocks[3]);
/* One flag per block; count is their number. */
GICUBE_API gicube_status gicube_set_empty_flags(gicube_board* board, const uint8_t* flags, size_t count);
GICUBE_API gicube_status gicube_get_empty_flags(gicube_board* board, uint8_t* flags, size_t count);

/* Global illumination. report may be NULL. */
GICUBE_API gicube_status gicube_illuminate(gicube_board* board, const gicube_light* lights, size_t count,
                                           const gicube_illumination* settings, gicube_progress progress, void* user,
                                           gicube_lighting_report* report);
/* Warning `index` of the last gicube_illuminate(); NULL if there is none. Until this board's next one. */
GICUBE_API const char* gicube_lighting_warning(gicube_board* board, uint32_t index);
/* One value per voxel, or three (gicube_board_info.irradiance_words), of the box or, if it is NULL, the whole volume.
 * count is their number. */
GICUBE_API gicube_status gicube_read_irradiance(gicube_board* board, const gicube_box* box, float* values,
                                                size_t count);
GICUBE_API gicube_status gicube_write_irradiance(gicube_board* board, const gicube_box* box, const float* values,
                                                 size_t count);
GICUBE_API gicube_status gicube_clear_irradiance(gicube_board* board, double unit);
/* Sums of rays of type GICUBE_RAY_BACKPROJECT; one value per voxel of the box. */
GICUBE_API gicube_status gicube_clear_sums(gicube_board* board, double unit);
GICUBE_API gicube_status gicube_read_sums(gicube_board* board, const gicube_box* box, float* values, size_t count);

/* Pictures; count is width times height, rows from the top. */
GICUBE_API gicube_status gicube_render_to_framebuffer(gicube_board* board, const gicube_view* view,
                                                      gicube_progress progress, void* user);
/* Size of the picture in the framebuffer; 0 x 0 before the first one. */
GICUBE_API gicube_status gicube_get_framebuffer_size(gicube_board* board, int32_t* width, int32_t* height);
GICUBE_API gicube_status gicube_read_framebuffer(gicube_board* board, gicube_pixel* pixels, size_t count);
/* Both. */
GICUBE_API gicube_status gicube_render(gicube_board* board, const gicube_view* view, gicube_pixel* pixels, size_t count,
                                       gicube_progress progress, void* user);
/* The likely reason why nothing is visible in the last picture read, as a sentence; NULL if something is. Until the
 * next one is read. */
GICUBE_API const char* gicube_why_invisible(gicube_board* board);

/* The ray from one point to another, for types of rays that have a length. */
GICUBE_API gicube_status gicube_ray_between(uint32_t id, const double from[3], const double to[3],
                                            gicube_host_ray* ray);
/* Rays. request may be NULL: integrate. The caller's memory is free again on return; *ticket is 0 unless it succeeds.
 */
GICUBE_API gicube_status gicube_submit(gicube_board* board, const gicube_host_ray* rays, size_t count,
                                       const gicube_ray_request* request, uint32_t* ticket);
/* Submits rays from several arrays as one batch, in that order. */
GICUBE_API gicube_status gicube_submit_gather(gicube_board* board, const gicube_ray_span* spans, size_t span_count,
                                              const gicube_ray_request* request, uint32_t* ticket);
GICUBE_API gicube_status gicube_submit_polylines(gicube_board* board, const gicube_polyline* lines, size_t count,
                                                 uint32_t* ticket);
/* Waits for that batch, and writes its rays; count is as many as were submitted (polylines: legs; deposits and
 * backprojection: any, since none come back). report may be NULL. After GICUBE_DEADLINE_PASSED and GICUBE_BAD_ARGUMENT
 * the batch is still there. */
GICUBE_API gicube_status gicube_receive(gicube_board* board, uint32_t ticket, uint64_t deadline_ps,
                                        gicube_traced_ray* rays, size_t count, gicube_batch_report* report);
/* The next batch that has arrived by now, in the order of their arrival; gicube_receive() gives its rays.
 * report->ticket is 0 if there is none. */
GICUBE_API gicube_status gicube_poll(gicube_board* board, gicube_batch_report* report);
/* A file descriptor that becomes readable when gicube_receive() would no longer have to wait for the board's work, or
 * if the board is lost or closed: for poll() and event loops (gicube/board.h, descriptor()). The caller closes it. */
GICUBE_API gicube_status gicube_batch_descriptor(gicube_board* board, uint32_t ticket, int* descriptor);
/* *cancelled is 0 if it is too late: the batch comes back whole. It comes back in either case. */
GICUBE_API gicube_status gicube_cancel(gicube_board* board, uint32_t ticket, int32_t* cancelled);

/* How much light goes between pairs of elements; count is the number of pairs. request may be NULL. */
GICUBE_API gicube_status gicube_pair_factors(gicube_board* board, const gicube_element* elements, size_t element_count,
                                             const gicube_element_pair* pairs, size_t pair_count,
                                             const gicube_pair_request* request, gicube_progress progress, void* user,
                                             gicube_pair_factor* factors, size_t count);

/* Calls that continue while the application does something else (gicube/pending.h): each does what the call of the same
 * name does, with the same bits and simulated times, on a thread of the driver and in its place in the order of the
 * calls. *pending is NULL unless it succeeds. What was handed over may be freed on return, but the volume's arrays
 * must stay until the call has ended. Batches of rays need none of this: gicube_submit() does not wait. */
GICUBE_API gicube_status gicube_start_load_volume(gicube_board* board, const gicube_volume* volume,
                                                  gicube_pending** pending);
GICUBE_API gicube_status gicube_start_render(gicube_board* board, const gicube_view* view, gicube_pending** pending);
GICUBE_API gicube_status gicube_start_illuminate(gicube_board* board, const gicube_light* lights, size_t count,
                                                 const gicube_illumination* settings, gicube_pending** pending);
GICUBE_API gicube_status gicube_start_pair_factors(gicube_board* board, const gicube_element* elements,
                                                   size_t element_count, const gicube_element_pair* pairs,
                                                   size_t pair_count, const gicube_pair_request* request,
                                                   gicube_pending** pending);
/* Waits until it has ended, but not longer than timeout_ms of wall-clock time. *ready is 1 if it has. No simulated
 * time passes. */
GICUBE_API gicube_status gicube_pending_wait(const gicube_pending* pending, uint64_t timeout_ms, int32_t* ready);
/* Asks the call to end. *cancelled is 1 if it does, or will: its gicube_finish_...() is GICUBE_STOPPED then. 0: it had
 * ended. */
GICUBE_API gicube_status gicube_pending_cancel(gicube_pending* pending, int32_t* cancelled);
/* Parts done and parts in all; 0 of 0 before the call has said so. */
GICUBE_API gicube_status gicube_pending_progress(const gicube_pending* pending, uint32_t* done, uint32_t* all);
/* A file descriptor that becomes readable when the call has ended, for poll() and event loops. The caller closes it. */
GICUBE_API gicube_status gicube_pending_descriptor(const gicube_pending* pending, int* descriptor);
/* Wait for the end, and give the result, once: of the start of the same name. They return what the blocking call
 * would, and GICUBE_DEADLINE_PASSED if the result comes after deadline_ps of simulated time: it can still be asked
 * for. So it can after an array of a wrong size, which is GICUBE_BAD_ARGUMENT. report may be NULL.
 * gicube_lighting_warning() and gicube_why_invisible() have their words. */
GICUBE_API gicube_status gicube_finish_load_volume(gicube_pending* pending, uint64_t deadline_ps);
GICUBE_API gicube_status gicube_finish_render(gicube_pending* pending, uint64_t deadline_ps, gicube_pixel* pixels,
                                              size_t count);
GICUBE_API gicube_status gicube_finish_illuminate(gicube_pending* pending, uint64_t deadline_ps,
                                                  gicube_lighting_report* report);
GICUBE_API gicube_status gicube_finish_pair_factors(gicube_pending* pending, uint64_t deadline_ps,
                                                    gicube_pair_factor* factors, size_t count);
/* Frees the handle. A call that has not ended continues, and its result is dropped. Call it before gicube_close() of
 * its board. NULL is no call and no error. */
GICUBE_API void gicube_pending_free(gicube_pending* pending);

/* Simulated time. */
GICUBE_API gicube_status gicube_now(gicube_board* board, uint64_t* now_ps);
GICUBE_API gicube_status gicube_host_compute(gicube_board* board, uint64_t duration_ps);
/* Time limit of renderings and of gicube_illuminate(); 0: none. */
GICUBE_API gicube_status gicube_set_time_limit(gicube_board* board, uint64_t limit_ps);

/* The counters' values at this moment: a list, which the caller frees. */
GICUBE_API gicube_status gicube_get_counters(gicube_board* board, gicube_counter_list** list);
GICUBE_API void gicube_counters_free(gicube_counter_list* list);
GICUBE_API size_t gicube_counters_count(const gicube_counter_list* list);
/* name and unit live as long as the list; each pointer may be NULL. */
GICUBE_API gicube_status gicube_counters_at(const gicube_counter_list* list, size_t index, const char** name,
                                            const char** unit, uint64_t* value);
/* GICUBE_UNSUPPORTED if this board's fidelity level does not keep it; *value is 0 then. */
GICUBE_API gicube_status gicube_counters_value(const gicube_counter_list* list, const char* name, uint64_t* value);

/* NOLINTEND(modernize-use-using, readability-identifier-naming) */

#ifdef __cplusplus
}
#endif

#endif
