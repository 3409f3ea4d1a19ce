/*
 * Shisen: a ray tracer of fixed budgets whose detail follows the gaze, and a
 * driver for eye and head trackers. This is its C library, libshisen.a.
 *
 * A display controller opens a baked scene where it lies in flash
 * (shisen_scene_open), feeds its tracker's bytes as they come
 * (shisen_tracker_feed), asks where the viewer looks when the next frame will be
 * seen (shisen_tracker_gaze), begins a frame of its screens
 * (shisen_frame_begin), and renders it in slices of a fixed budget
 * (shisen_frame_render), tile by tile from the line of sight outwards. Complete
 * programs are in core/capi/examples.
 *
 * There is no global state, no callback and no allocation. All state is in the
 * caller's memory: how much it takes, and at what addresses it can be, say the
 * macros SHISEN_..._SIZE and SHISEN_ALIGNMENT and the functions of the same names.
 * It can be static or on the heap:
 *
 *     static uint64_t memory[(SHISEN_SCENE_SIZE + 7) / 8];
 *
 * Handles may be used by one thread at a time, a scene by any number. They must
 * not be moved or copied. None has to be closed: memory that is not used any more
 * can be used for something else.
 *
 * Pointers are checked for NULL and alignment, lengths for making sense, and
 * what a scene or a tracker says for being possible. Nobody can check that there
 * is memory behind a pointer: see "Safety" at each function.
 *
 * Axes are right-handed, in metres: +X right, +Y up, -Z forward. Colours are
 * linear. Times are microseconds by one clock of the caller's, which must never
 * go back.
 *
 * Made by cbindgen from core/capi/src: do not edit.
 */


#ifndef SHISEN_H
#define SHISEN_H

#include <stddef.h>
#include <stdint.h>

/* Handles hold pointers, so their sizes depend on the size of a pointer. */
#if UINTPTR_MAX > 0xFFFFFFFFu
#define SHISEN_POINTERS_64
#else
#define SHISEN_POINTERS_32
#endif

/* Number of tiles of side * side pixels in a picture. */
#define SHISEN_TILES(columns, rows, side) \
    ((((size_t)(columns) + (side)-1) / (side)) * (((size_t)(rows) + (side)-1) / (side)))

/* Bytes of memory for a frame of `pictures` pictures with `tiles` tiles in all. */
#define SHISEN_FRAME_BYTES(pictures, tiles) \
    (SHISEN_FRAME_SIZE + (pictures)*SHISEN_PICTURE_SIZE + (tiles)*SHISEN_TILE_SIZE)


// Least status that is a failure: the failed call has changed nothing, unless
// its description says otherwise.
#define SHISEN_FIRST_FAILURE 16

// Alignment of memory for handles, bytes: that of uint64_t.
#define SHISEN_ALIGNMENT 8

#if defined(SHISEN_POINTERS_32)
// Bytes of memory for a scene's handle.
#define SHISEN_SCENE_SIZE 144
#endif

#if defined(SHISEN_POINTERS_64)
// Bytes of memory for a scene's handle.
#define SHISEN_SCENE_SIZE 288
#endif

// Alignment of a baked scene, bytes.
#define SHISEN_BLOB_ALIGNMENT 32

// Effect: objects cast shadows.
#define SHISEN_EFFECT_SHADOWS 65536

// Effect: mirrors.
#define SHISEN_EFFECT_REFLECTION 2

// Effect: clear bodies.
#define SHISEN_EFFECT_REFRACTION 4

// Effect: clear bodies refract each wavelength differently.
#define SHISEN_EFFECT_DISPERSION 256

// Effect: clear bodies absorb light.
#define SHISEN_EFFECT_ABSORPTION 8

// Effect: clear bodies within one another.
#define SHISEN_EFFECT_NESTED_MEDIA 8192

// Effect: lights with a size.
#define SHISEN_EFFECT_SOFT_LIGHT 131072

// Effect: lights that shine into cones.
#define SHISEN_EFFECT_SPOT_LIGHT 262144

// Effect: shadows that light comes through.
#define SHISEN_EFFECT_CLEAR_SHADOWS 524288

// Effect: an image as the background.
#define SHISEN_EFFECT_ENVIRONMENT 1048576

// Effect: images on surfaces.
#define SHISEN_EFFECT_IMAGE_TEXTURE 64

// Effect: checkers on surfaces.
#define SHISEN_EFFECT_CHECKER_TEXTURE 32

// Effect: normals that images bend.
#define SHISEN_EFFECT_NORMAL_MAP 16384

// Effect: textures as coarse as what a pixel sees of them.
#define SHISEN_EFFECT_TEXTURE_LEVELS 4096

// Effect: surfaces that shine.
#define SHISEN_EFFECT_EMISSION 128

// Effect: meridians and parallels on a surface.
#define SHISEN_EFFECT_GRATICULE 16

// Effect: microfacets, of metal and of what is more or less rough.
#define SHISEN_EFFECT_MICROFACETS 512

// Effect: surfaces with holes, or more or less opaque from place to place.
#define SHISEN_EFFECT_ALPHA 2048

// Effect: colours of vertices.
#define SHISEN_EFFECT_VERTEX_COLOURS 1024

#if defined(SHISEN_POINTERS_32)
// Bytes of memory for a tracker's handle, for every protocol.
#define SHISEN_TRACKER_SIZE 6592
#endif

#if defined(SHISEN_POINTERS_64)
// Bytes of memory for a tracker's handle, for every protocol.
#define SHISEN_TRACKER_SIZE 6896
#endif

#if defined(SHISEN_POINTERS_32)
// Bytes of memory for setting a device up.
#define SHISEN_SETUP_SIZE 1376
#endif

#if defined(SHISEN_POINTERS_64)
// Bytes of memory for setting a device up.
#define SHISEN_SETUP_SIZE 1400
#endif

// Most bytes that shisen_tracker_poll writes at once.
#define SHISEN_MOST_COMMAND_BYTES 48

// Number of reasons to drop bytes: see shisen_drop_reason.
#define SHISEN_DROP_REASONS 9

// The age of a gaze that never came.
#define SHISEN_NEVER UINT64_MAX

// Bytes of memory for a spectrum's handle, without its wavelengths.
#define SHISEN_SPECTRUM_SIZE 32

// Bytes of memory for a wavelength of a spectrum's handle: `count` + 3 of them
// are needed for each of the SHISEN_SPECTRUM_PHASES.
#define SHISEN_WAVELENGTH_SIZE 16

// Offsets that the wavelengths are taken at.
#define SHISEN_SPECTRUM_PHASES 32

#if defined(SHISEN_POINTERS_32)
// Bytes of memory for a frame's handle, without its pictures and tiles.
#define SHISEN_FRAME_SIZE 2712
#endif

#if defined(SHISEN_POINTERS_64)
// Bytes of memory for a frame's handle, without its pictures and tiles.
#define SHISEN_FRAME_SIZE 2896
#endif

#if defined(SHISEN_POINTERS_32)
// Bytes of memory for each picture of a frame's handle.
#define SHISEN_PICTURE_SIZE 128
#endif

#if defined(SHISEN_POINTERS_64)
// Bytes of memory for each picture of a frame's handle.
#define SHISEN_PICTURE_SIZE 128
#endif

// Bytes of memory for each tile of a frame's handle.
#define SHISEN_TILE_SIZE 12

// Most pixels a side of a tile.
#define SHISEN_LARGEST_TILE 256

// A budget that no frame spends.
#define SHISEN_UNLIMITED UINT64_MAX

// How a call went. From SHISEN_FIRST_FAILURE on it failed.
enum shisen_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Done.
    SHISEN_STATUS_OK = 0,
    // A tile's pixels are there.
    SHISEN_STATUS_TILE = 1,
    // The call's budget is spent; call again to go on.
    SHISEN_STATUS_BUDGET_SPENT = 2,
    // All tiles of the frame have been handed over.
    SHISEN_STATUS_FINISHED = 3,
    // A pointer is NULL that may not be.
    SHISEN_STATUS_NULL_POINTER = 16,
    // A pointer is not at a multiple of the alignment of what it points to.
    SHISEN_STATUS_MISALIGNED = 17,
    // The memory is less than what the functions and macros of sizes say.
    SHISEN_STATUS_MEMORY_TOO_SMALL = 18,
    // A length is more than memory can be.
    SHISEN_STATUS_TOO_LONG = 19,
    // The library was built without what is asked for.
    SHISEN_STATUS_NOT_BUILT = 20,
    // The scene is shorter than it says, or than a header. Number: bytes that
    // it should have.
    SHISEN_STATUS_SCENE_CUT_OFF = 32,
    // The scene is not at a multiple of SHISEN_BLOB_ALIGNMENT. Number: that.
    SHISEN_STATUS_SCENE_MISALIGNED = 33,
    // The bytes do not start like a scene.
    SHISEN_STATUS_NOT_A_SCENE = 34,
    // The scene was baked by another version of the format. Number: which.
    SHISEN_STATUS_SCENE_VERSION = 35,
    // The scene was baked in the fast layout for hosts, not in the compact one.
    // Number: children of its nodes.
    SHISEN_STATUS_SCENE_LAYOUT = 36,
    // The scene was damaged since it was baked. Number: its bytes' checksum.
    SHISEN_STATUS_SCENE_CHECKSUM = 37,
    // A table is not inside the scene, or not aligned. Number: its byte.
    SHISEN_STATUS_SCENE_TABLE = 38,
    // A table has another length than the scene gives it. Number: its records.
    SHISEN_STATUS_SCENE_COUNT = 39,
    // A record names what is not there, or another's. Number: the record.
    SHISEN_STATUS_SCENE_INDEX = 40,
    // Nodes are not a tree. Number: the node.
    SHISEN_STATUS_SCENE_TREE = 41,
    // A tree is too deep for the traversal stack. Number: entries needed.
    SHISEN_STATUS_SCENE_DEPTH = 42,
    // A mesh does not fit its ladder of polygon levels. Number: the mesh.
    SHISEN_STATUS_SCENE_LADDER = 43,
    // The scene says other effects than its records. Number: theirs.
    SHISEN_STATUS_SCENE_EFFECTS = 44,
    // A record has a value that is out of range. Number: the record.
    SHISEN_STATUS_SCENE_VALUE = 45,
    // The scene is wrong in another way.
    SHISEN_STATUS_SCENE_OTHER = 46,
    // There is no protocol or eye of this number.
    SHISEN_STATUS_UNKNOWN_CHOICE = 64,
    // A tracker's pose is not finite or no rotation, or its delay out of range.
    SHISEN_STATUS_TRACKER_SETTINGS = 65,
    // Nothing comes from the device, or nothing more: check that it is on and the
    // cable is the right one, with its lines crossed or not.
    SHISEN_STATUS_DEVICE_SILENT = 66,
    // Bytes come from the device, and no record among them: the line's speed or
    // the protocol is not the device's.
    SHISEN_STATUS_DEVICE_NO_RECORD = 67,
    // Records come from the device, but not the one that was asked for.
    SHISEN_STATUS_DEVICE_NO_ANSWER = 68,
    // The device refused a command.
    SHISEN_STATUS_DEVICE_REFUSED = 69,
    // The commands do not fit the memory for them.
    SHISEN_STATUS_DEVICE_COMMANDS = 70,
    // Most of what comes from the device is dropped: it speaks another protocol,
    // has other settings, the line has another speed, or a sensor is not plugged
    // in.
    SHISEN_STATUS_DEVICE_UNLIKE = 71,
    // The depth or the samples are out of range.
    SHISEN_STATUS_FRAME_SETTINGS = 96,
    // Tiles have no pixels or more than 256 a side.
    SHISEN_STATUS_TILE_SIZE = 97,
    // A frame has no pictures or more than 65,535.
    SHISEN_STATUS_PICTURES = 98,
    // A picture has no pixels or more than 65,536 a side.
    SHISEN_STATUS_PICTURE_SIZE = 99,
    // The eye, or a dome master's place, is not finite or too far out.
    SHISEN_STATUS_EYE = 100,
    // The eye is behind a screen or in its plane.
    SHISEN_STATUS_EYE_BEHIND_SCREEN = 101,
    // A screen's steps are parallel, zero or not finite.
    SHISEN_STATUS_SCREEN = 102,
    // The gaze is not finite, zero, or its up is along it. Give NULL for a gaze
    // that is not known.
    SHISEN_STATUS_GAZE = 103,
    // A dome master's axes are not of unit length at right angles,
    // right-handed.
    SHISEN_STATUS_DOME_AXES = 104,
    // A dome master's mirror, or its viewpoint, is out of range.
    SHISEN_STATUS_DOME_MIRROR = 105,
    // Room for fewer pixels than a tile has.
    SHISEN_STATUS_PIXELS_TOO_FEW = 106,
    // There is no such set of wavelengths.
    SHISEN_STATUS_WAVELENGTHS = 107,
    // A medium of the scene is not known at all these wavelengths.
    SHISEN_STATUS_WAVELENGTHS_OF_MEDIUM = 108,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum shisen_status shisen_status;
#else
typedef uint32_t shisen_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A protocol that trackers speak.
enum shisen_protocol
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Shisen's own link: all that a tracker can know of head and eyes.
    SHISEN_PROTOCOL_LINK = 0,
    // Polhemus FASTRAK and InterSense IS-600, IS-900: the head, in binary
    // positions and quaternions, inches.
    SHISEN_PROTOCOL_FASTRAK = 1,
    // Polhemus Liberty and Patriot: the head, in binary positions, quaternions
    // and times, inches.
    SHISEN_PROTOCOL_LIBERTY = 2,
    // Ascension Flock of Birds, one bird: the head.
    SHISEN_PROTOCOL_FLOCK = 3,
    // Hatire: the head.
    SHISEN_PROTOCOL_HATIRE = 4,
    // ISCAN: one eye, in raw units.
    SHISEN_PROTOCOL_ISCAN = 5,
    // ASL EYE-TRAC: one eye, in raw units.
    SHISEN_PROTOCOL_ASL = 6,
    // AdHawk: both eyes, and how the head is turned.
    SHISEN_PROTOCOL_ADHAWK = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum shisen_protocol shisen_protocol;
#else
typedef uint32_t shisen_protocol;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The eye whose line of sight is used.
enum shisen_eye_choice
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The device's combined eye; without one, the mean of both eyes, or the one
    // that the device sees.
    SHISEN_EYE_CHOICE_COMBINED = 0,
    // The left eye alone.
    SHISEN_EYE_CHOICE_LEFT = 1,
    // The right eye alone.
    SHISEN_EYE_CHOICE_RIGHT = 2,
    // No eye: the head's direction is used.
    SHISEN_EYE_CHOICE_NONE = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum shisen_eye_choice shisen_eye_choice;
#else
typedef uint32_t shisen_eye_choice;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How far a gaze can be relied on; a greater number is worse.
enum shisen_gaze_state
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Gaze and head are recent.
    SHISEN_GAZE_STATE_FRESH = 0,
    // The last gaze is held: a blink, a reflection, a few lost samples.
    SHISEN_GAZE_STATE_HOLD = 1,
    // The gaze is near where it was: the field of full detail widens.
    SHISEN_GAZE_STATE_WIDENED = 2,
    // The eyes' direction is not known; the head's direction is used.
    SHISEN_GAZE_STATE_HEAD_DIRECTION = 3,
    // Neither eyes nor head are known: full detail everywhere.
    SHISEN_GAZE_STATE_FULL_QUALITY = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum shisen_gaze_state shisen_gaze_state;
#else
typedef uint32_t shisen_gaze_state;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Why bytes were dropped: an index into `dropped` of shisen_tracker_counts.
enum shisen_drop_reason
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Bytes between records that do not start a record.
    SHISEN_DROP_REASON_OUT_OF_STEP = 0,
    // A record broke off before its end.
    SHISEN_DROP_REASON_TRUNCATED = 1,
    // The protocol has no record of this length.
    SHISEN_DROP_REASON_LENGTH = 2,
    // The record's checksum does not match.
    SHISEN_DROP_REASON_CHECKSUM = 3,
    // A field holds a value that the protocol does not allow.
    SHISEN_DROP_REASON_FIELD = 4,
    // A number is infinite, NaN, or not one the sensor can measure.
    SHISEN_DROP_REASON_OUT_OF_RANGE = 5,
    // A direction or a quaternion has no length.
    SHISEN_DROP_REASON_NOT_UNIT = 6,
    // An unknown version or kind of record.
    SHISEN_DROP_REASON_UNKNOWN = 7,
    // The record repeats the one before.
    SHISEN_DROP_REASON_DUPLICATE = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum shisen_drop_reason shisen_drop_reason;
#else
typedef uint32_t shisen_drop_reason;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The caller's next step in setting a device up.
enum shisen_setup_action
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Send the bytes in the buffer, `length` of them, then poll again at once.
    SHISEN_SETUP_ACTION_SEND = 0,
    // Change the line to `baud` once all bytes are sent, then poll again at once.
    SHISEN_SETUP_ACTION_SPEED = 1,
    // Poll again at `until_us`, and after each call of shisen_tracker_feed.
    SHISEN_SETUP_ACTION_WAIT = 2,
    // The device is set up, or needs no set-up. The set-up's memory is free again.
    SHISEN_SETUP_ACTION_DONE = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum shisen_setup_action shisen_setup_action;
#else
typedef uint32_t shisen_setup_action;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A frame on its way to being finished. It refers to its scene and spectrum,
// and to itself: none of them may move.
typedef struct shisen_frame shisen_frame;

// A scene that has been checked. It refers to the baked scene's bytes, which
// stay the caller's: they must neither change nor move as long as the scene or
// a frame of it is in use. It never changes, so that any number of frames and
// threads can use it at once.
typedef struct shisen_scene shisen_scene;

// Wavelengths that rays take in media that bend each of them their own way.
typedef struct shisen_spectrum shisen_spectrum;

// A tracker, what is known of its clock, and where the viewer looks.
typedef struct shisen_tracker shisen_tracker;

// Why a scene was refused.
typedef struct shisen_scene_fault {
    // The shisen_status of the refusal.
    uint32_t status;
    // A byte, a record or a size, by the status's description.
    uint64_t number;
    // The table or value at fault, in English: `what_length` bytes without a
    // zero at their end. NULL if the status says all. The library owns the
    // text, which stays valid.
    const char *what;
    // Number of bytes of `what`.
    size_t what_length;
} shisen_scene_fault;

// Facts about a scene.
typedef struct shisen_scene_facts {
    // The effects that it asks for: SHISEN_EFFECT_... bits. Effects outside
    // shisen_effects() are not rendered.
    uint32_t effects;
    // Its length in bytes, which may be less than the length given.
    uint32_t byte_length;
    // Number of polygon levels of its meshes; 1 if it was baked without levels.
    uint32_t polygon_levels;
    // Number of placed shapes.
    uint32_t objects;
    // Number of lights.
    uint32_t lights;
} shisen_scene_facts;

// Settings of a tracker: see shisen_tracker_settings_init.
typedef struct shisen_tracker_settings {
    // The device's protocol: a shisen_protocol.
    uint32_t protocol;
    // The eye that is used: a shisen_eye_choice.
    uint32_t eyes;
    // Whether the device measures the head (1); if not (0), the head rests at
    // `position` and `orientation`.
    uint32_t head_tracked;
    // Samples per second that set-up asks the device for, if its protocol has a
    // command for that; at most 65,535. 0: the device's own rate.
    uint32_t hertz;
    // Least time from a measurement to the arrival of its last byte:
    // microseconds, at most 1,000,000.
    uint64_t least_delay_us;
    // The tracker's origin in the room, metres.
    float position[3];
    // The tracker's axes in the room: a unit quaternion x, y, z, w.
    float orientation[4];
} shisen_tracker_settings;

// Where the viewer looks.
typedef struct shisen_gaze {
    // The point between the eyes: metres, in the room.
    float position[3];
    // The line of sight: a unit vector, in the room. To begin a frame it may
    // have any length but zero.
    float forward[3];
    // Towards the top of the head: a unit vector at a right angle to `forward`.
    // To begin a frame it may have any length but zero, at any angle but
    // along `forward`.
    float up[3];
    // Angle by which the field of full detail is widened: radians. From π on the
    // field is everything.
    float widen;
    // How far the gaze can be relied on: a shisen_gaze_state.
    uint32_t state;
    // Whether the eyes were shut in the newest sample that says so: 0 or 1.
    uint32_t blink;
    // Age of the newest gaze at the time of display: microseconds;
    // SHISEN_NEVER if no gaze ever came.
    uint64_t age_us;
} shisen_gaze;

// Counts of a tracker's bytes and records. A count stops at its largest value.
typedef struct shisen_tracker_counts {
    // Bytes received.
    uint64_t bytes;
    // Records with a sample.
    uint64_t samples;
    // Records without a sample, such as a fault or an answer.
    uint64_t messages;
    // Records that the device's own count says are missing.
    uint64_t lost;
    // Bytes dropped.
    uint64_t dropped_bytes;
    // Number of times that bytes were dropped, by shisen_drop_reason.
    uint32_t dropped[SHISEN_DROP_REASONS];
} shisen_tracker_counts;

// The answer of shisen_tracker_poll.
typedef struct shisen_setup {
    // The next step: a shisen_setup_action.
    uint32_t action;
    // The line's speed, bits per second, for SPEED.
    uint32_t baud;
    // Number of bytes in the buffer, for SEND.
    size_t length;
    // Time of the next poll by the caller's clock, microseconds, for WAIT.
    uint64_t until_us;
} shisen_setup;

// A flat screen: the places of its pixels, for any eye. Metres, in the room.
typedef struct shisen_screen {
    // The centre of its first pixel: upper left, seen from in front of it.
    float first_pixel[3];
    // Step from a pixel to its right-hand neighbour.
    float column_step[3];
    // Step from a pixel to the one below it.
    float row_step[3];
    // Pixels in a row, 1 to 65,536.
    uint32_t columns;
    // Pixels in a column, 1 to 65,536.
    uint32_t rows;
} shisen_screen;

// A dome master: a square picture of half of all directions, reflected at the
// spheroid of least error, each pixel its own exact direction. Pixels outside
// its rim are transparent and cost nothing.
typedef struct shisen_dome {
    // The screen's centre in the room, metres.
    float position[3];
    // The picture's right, in the room: a unit vector.
    float right[3];
    // The picture's top, in the room: a unit vector.
    float top[3];
    // Against the zenith, in the room: a unit vector. The three are at right
    // angles and right-handed.
    float behind[3];
    // The mirror's equatorial radius: metres, 1e-9 to 1e6.
    float radius;
    // Pixels a side, 1 to 65,536.
    uint32_t size;
} shisen_dome;

// Quality and cost of a frame: see shisen_frame_settings_init.
typedef struct shisen_frame_settings {
    // Most reflections and refractions in a row, 0 to 16.
    uint32_t depth;
    // Rays a pixel, 1 to 4,096.
    uint32_t samples;
    // Pixels a side of a tile, 1 to 256.
    uint32_t tile_side;
    // Whether the level of detail follows the gaze (1), or all is rendered in
    // full detail (0).
    uint32_t follow_gaze;
    // Steps that the whole frame may take: one for each node visited, one for each
    // primitive tested. Pixels that the budget does not reach show the background.
    uint64_t budget;
    // The wavelengths of dispersion. NULL: glass bends all wavelengths alike.
    const struct shisen_spectrum *spectrum;
} shisen_frame_settings;

// A pixel: linear light with sRGB's primaries, 1 being white, premultiplied by
// coverage.
typedef struct shisen_pixel {
    // Red.
    float red;
    // Green.
    float green;
    // Blue.
    float blue;
    // Coverage: 0 where only a transparent background is seen, 1 where none is.
    float alpha;
} shisen_pixel;

// A finished tile.
typedef struct shisen_tile {
    // The index of its screen when the frame was begun; 0 for a dome master.
    uint32_t picture;
    // Its first column.
    uint32_t x;
    // Its first row.
    uint32_t y;
    // Pixels in a row: the side of tiles, or less at the picture's border.
    uint32_t columns;
    // Pixels in a column: the side of tiles, or less at the picture's border.
    uint32_t rows;
    // Whether all its pixels were traced (1); if the budget did not last (0),
    // some or all of them show the background.
    uint32_t whole;
} shisen_tile;

// Counts of what a frame has done so far.
typedef struct shisen_frame_counts {
    // Rays from the eye.
    uint64_t primary_rays;
    // Rays reflected by mirrors and glass.
    uint64_t reflected_rays;
    // Rays into and out of glass.
    uint64_t refracted_rays;
    // Rays to lights.
    uint64_t shadow_rays;
    // Nodes visited and primitives tested.
    uint64_t steps;
    // Steps left of the frame's budget.
    uint64_t budget_left;
    // Tiles handed over all of whose pixels were traced.
    uint32_t tiles_whole;
    // Tiles handed over that the frame's budget did not finish.
    uint32_t tiles_given_up;
} shisen_frame_counts;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Returns a status' name, such as "SHISEN_STATUS_OK"; "SHISEN_STATUS_?" for numbers
// that are none. The text is the library's and stays.
const char *shisen_status_name(uint32_t status);

// Returns what a status means and what to do, in one line without a full stop.
// The library owns the text, which stays valid.
const char *shisen_status_message(uint32_t status);

// Returns SHISEN_ALIGNMENT, the alignment of memory for handles.
size_t shisen_alignment(void);

// Returns SHISEN_SCENE_SIZE, the bytes of memory for a scene's handle.
size_t shisen_scene_size(void);

// Returns the effects that this library renders: SHISEN_EFFECT_... bits.
uint32_t shisen_effects(void);

// Checks a scene that was baked in the compact layout (`shisen bake --layout
// compact`) and makes a handle for it. This reads all its bytes, once.
//
// `memory`, `memory_size`: for the handle, which needs SHISEN_SCENE_SIZE bytes
// at a multiple of SHISEN_ALIGNMENT.
// `blob`, `blob_length`: the scene, at a multiple of SHISEN_BLOB_ALIGNMENT. Bytes
// after the scene's own length are ignored, so that a whole region of flash can
// be given.
// `scene`: receives the handle; NULL after a failure.
// `fault`: receives the reason if the scene is refused; may be NULL.
//
// # Safety
// Each pointer is NULL, misaligned, or valid: `memory` for `memory_size` bytes,
// `blob` for `blob_length`, the others for one value. Nobody else changes that
// memory during the call. The blob stays unchanged for as long as the scene or a
// frame of it is in use.
shisen_status shisen_scene_open(void *memory,
                                size_t memory_size,
                                const uint8_t *blob,
                                size_t blob_length,
                                struct shisen_scene **scene,
                                struct shisen_scene_fault *fault);

// Says what a scene is like.
//
// # Safety
// `scene` is NULL or a scene that was opened; `facts` is NULL, misaligned, or
// points to memory for one.
shisen_status shisen_scene_describe(const struct shisen_scene *scene,
                                    struct shisen_scene_facts *facts);

// Returns SHISEN_TRACKER_SIZE, the bytes of memory for a tracker's handle.
size_t shisen_tracker_size(void);

// Returns SHISEN_SETUP_SIZE, the bytes of memory for setting a device up.
size_t shisen_setup_size(void);

// Writes the default settings for `protocol`, a shisen_protocol: the tracker's
// origin and axes are the room's, and it measures all that the protocol can send.
//
// # Safety
// `settings` is NULL, misaligned, or points to memory for one TrackerSettings.
shisen_status shisen_tracker_settings_init(struct shisen_tracker_settings *settings,
                                           uint32_t protocol);

// Makes a tracker that has received no bytes yet.
//
// `memory`, `memory_size`: for the handle, which needs SHISEN_TRACKER_SIZE bytes
// at a multiple of SHISEN_ALIGNMENT. A tracker may be abandoned at any time.
// `tracker`: receives the handle; NULL after a failure.
//
// # Safety
// Each pointer is NULL, misaligned, or valid: `memory` for `memory_size` bytes,
// the others for one value. Nobody else uses that memory during the call.
shisen_status shisen_tracker_init(void *memory,
                                  size_t memory_size,
                                  const struct shisen_tracker_settings *settings,
                                  struct shisen_tracker **tracker);

// Takes the next bytes of the tracker's stream, in pieces of any length. The last
// byte came in at `arrival_us` by the caller's clock, which must never go back:
// microseconds. Noise is dropped and counted.
//
// # Safety
// `tracker` is NULL or a tracker that was made, used by nobody else during the call; `bytes`
// is NULL or points to `length` bytes.
shisen_status shisen_tracker_feed(struct shisen_tracker *tracker,
                                  const uint8_t *bytes,
                                  size_t length,
                                  uint64_t arrival_us);

// Estimates where the viewer looks at `display_us`, when the frame will be seen,
// by the clock of shisen_tracker_feed: microseconds. There is always an answer;
// its `state` says how far it can be relied on.
//
// # Safety
// `tracker` is NULL or a tracker that was made, used by nobody else during the call; `gaze`
// is NULL, misaligned, or points to memory for a gaze.
shisen_status shisen_tracker_gaze(struct shisen_tracker *tracker,
                                  uint64_t display_us,
                                  struct shisen_gaze *gaze);

// Says what became of the bytes so far.
//
// # Safety
// `tracker` is NULL or a tracker that was made; `counts` is NULL, misaligned, or
// points to memory for them.
shisen_status shisen_tracker_count(const struct shisen_tracker *tracker,
                                   struct shisen_tracker_counts *counts);

// Forgets the piece of a record that has come in, as after bytes were lost: an
// overrun of the line, or a device that was unplugged. What is known of the
// gaze, and the counts, stay.
//
// # Safety
// `tracker` is NULL or a tracker that was made, used by nobody else during the call.
shisen_status shisen_tracker_resync(struct shisen_tracker *tracker);

// Begins to set the device up: shisen_tracker_poll then says what to send. A
// device that sends without being asked needs no set-up. Until the device has
// got all commands, but for at most 800 ms, its samples are ignored: their units
// may be wrong.
//
// `memory`, `memory_size`: SHISEN_SETUP_SIZE bytes at a multiple of SHISEN_ALIGNMENT,
// which stay the tracker's until polling it says SHISEN_SETUP_ACTION_DONE or
// fails.
// `reset`: whether the device is reset first (1), which takes some devices ten
// seconds, or not (0).
//
// # Safety
// `tracker` is NULL or a tracker that was made, used by nobody else during the call;
// `memory` is NULL, misaligned, or points to `memory_size` bytes, which nobody
// else uses until the set-up is done or has failed.
shisen_status shisen_tracker_set_up(struct shisen_tracker *tracker,
                                    void *memory,
                                    size_t memory_size,
                                    uint32_t reset);

// Says what is to be done to set the device up, at `now_us` on the clock of
// shisen_tracker_feed: microseconds. It never waits.
//
// A failure of the device (SHISEN_STATUS_DEVICE_...) is said once; then setting
// it up is over, and what it sends is believed.
//
// `buffer`, `buffer_size`: for bytes to be sent; SHISEN_MOST_COMMAND_BYTES.
//
// # Safety
// `tracker` is NULL or a tracker that was made, used by nobody else during the call;
// `buffer` is NULL or points to `buffer_size` bytes; `setup` is NULL,
// misaligned, or points to memory for one.
shisen_status shisen_tracker_poll(struct shisen_tracker *tracker,
                                  uint64_t now_us,
                                  uint8_t *buffer,
                                  size_t buffer_size,
                                  struct shisen_setup *setup);

// Computes a screen from three of its corners, seen from in front of it:
// metres, in the room.
//
// # Safety
// Each pointer is NULL, misaligned, or points to three numbers; `screen` to
// memory for a screen.
shisen_status shisen_screen_from_corners(const float lower_left[3],
                                         const float lower_right[3],
                                         const float upper_left[3],
                                         uint32_t columns,
                                         uint32_t rows,
                                         struct shisen_screen *screen);

// Returns bytes of memory for the handle of a spectrum of `count` wavelengths.
size_t shisen_spectrum_size(uint32_t count);

// Computes `count` wavelengths, 1 to 64, from `from_nm` to `to_nm`, which are
// nanometres from 360 to 830, and their colours, for shisen_frame_settings. Six
// wavelengths from 400 to 700 suffice for most scenes. Needs the cargo feature
// `dispersion`.
//
// `memory`, `memory_size`: shisen_spectrum_size(count) bytes at a multiple of
// SHISEN_ALIGNMENT, which the spectrum uses for as long as a frame that was begun
// with it is in use.
// `spectrum`: receives the handle; NULL after a failure.
//
// # Safety
// Each pointer is NULL, misaligned, or valid: `memory` for `memory_size` bytes,
// `spectrum` for one handle. Nobody else uses that memory during the call.
shisen_status shisen_spectrum_open(void *memory,
                                   size_t memory_size,
                                   uint32_t count,
                                   float from_nm,
                                   float to_nm,
                                   struct shisen_spectrum **spectrum);

// Returns a dome over a room, whose front is at the bottom of the picture of `size`²
// pixels, with a mirror of 1 mm. `position`: metres, in the room.
//
// # Safety
// `dome` is NULL, misaligned, or points to memory for one; `position` is NULL,
// misaligned, or points to three numbers.
shisen_status shisen_dome_init(struct shisen_dome *dome, const float position[3], uint32_t size);

// Returns how many tiles of `side`² pixels a picture of `columns` by `rows` pixels
// has: the function for the macro SHISEN_TILES.
size_t shisen_tiles(uint32_t columns, uint32_t rows, uint32_t side);

// Returns the bytes of memory for the handle of a frame with `pictures` pictures
// and `tiles` tiles in all: the function for the macro SHISEN_FRAME_BYTES.
size_t shisen_frame_size(size_t pictures, size_t tiles);

// Writes the default settings: three bounces, one ray a pixel, tiles of 16 pixels, a
// level of detail that follows the gaze, no limit.
//
// # Safety
// `settings` is NULL, misaligned, or points to memory for one FrameSettings.
shisen_status shisen_frame_settings_init(struct shisen_frame_settings *settings);

// Checks that a screen can be seen from `eye`: metres, in the room. A frame
// cannot begin with a screen that fails this.
//
// # Safety
// `screen` is NULL, misaligned, or points to a screen; `eye` is NULL, misaligned,
// or points to three numbers.
shisen_status shisen_screen_check(const struct shisen_screen *screen, const float eye[3]);

// Begins a frame of one eye's view of some screens. Its tiles go from the line
// of sight outwards, on all screens together; without a gaze by screen, row and
// column. This call sorts them, which takes time in proportion to their number
// and counts against no budget.
//
// `memory`, `memory_size`: for the handle, which needs SHISEN_FRAME_BYTES bytes
// at a multiple of SHISEN_ALIGNMENT. The frame uses it until another is
// begun in it; a frame may be abandoned at any time.
// `screens`, `screen_count`: 1 to 65,535 of them; they are copied.
// `eye`: metres, in the room.
// `gaze`: that eye's gaze, of which the position is ignored. NULL if it is not
// known: all is rendered in full detail.
// `frame`: receives the handle; NULL after a failure.
//
// # Safety
// Each pointer is NULL, misaligned, or valid: `memory` for `memory_size` bytes,
// `screens` for `screen_count` screens, `eye` for three numbers, the others for one
// value. Nobody else uses that memory during the call. The scene's, the spectrum's
// and the frame's memory neither moves nor changes while the frame is in use.
shisen_status shisen_frame_begin(void *memory,
                                 size_t memory_size,
                                 const struct shisen_scene *scene,
                                 const struct shisen_frame_settings *settings,
                                 const struct shisen_screen *screens,
                                 size_t screen_count,
                                 const float eye[3],
                                 const struct shisen_gaze *gaze,
                                 struct shisen_frame **frame);

// Begins a frame that is one dome master, in full detail. Tiles go by row and
// column. Parameters are those of shisen_frame_begin.
//
// # Safety
// The same as for shisen_frame_begin.
shisen_status shisen_frame_begin_dome(void *memory,
                                      size_t memory_size,
                                      const struct shisen_scene *scene,
                                      const struct shisen_frame_settings *settings,
                                      const struct shisen_dome *dome,
                                      struct shisen_frame **frame);

// Renders until a tile is finished (SHISEN_STATUS_TILE: `tile` describes it), the
// frame is finished (SHISEN_STATUS_FINISHED), or this call's budget is spent
// (SHISEN_STATUS_BUDGET_SPENT: call again to go on). Tiles that the frame's
// budget did not finish are handed over, too. A call takes at most its budget,
// 16 steps of a block's test and the steps of one sample: its ray tree and, in tile
// mode, a primary ray for each pixel of its block. The pixels do not depend on how
// the frame was cut into calls.
//
// `slice_budget`: steps that this call may take; 0 traces nothing.
// `pixels`, `pixel_count`: room for a tile of `tile_side` squared pixels; a smaller
// tile at a picture's border uses the first of them. The frame uses them until the
// tile is finished, when they hold its rows, from the top, without gaps. They need
// not be initialised.
//
// # Safety
// `frame` is NULL or a frame that was begun, used by nobody else during the call; `pixels`
// is NULL, misaligned, or points to `pixel_count` pixels; `tile` is NULL,
// misaligned, or points to memory for a tile.
shisen_status shisen_frame_render(struct shisen_frame *frame,
                                  uint64_t slice_budget,
                                  struct shisen_pixel *pixels,
                                  size_t pixel_count,
                                  struct shisen_tile *tile);

// Writes the counts of what a frame has done so far.
//
// # Safety
// `frame` is NULL or a frame that was begun; `counts` is NULL, misaligned, or
// points to memory for one FrameCounts.
shisen_status shisen_frame_count(const struct shisen_frame *frame,
                                 struct shisen_frame_counts *counts);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SHISEN_H */
