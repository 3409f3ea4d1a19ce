//! The border to C: pointers are checked before they are used.
//!
//! A pointer must not be NULL, must be aligned, and its length must be possible: these
//! are checked. The caller promises that memory of this length is behind it and that
//! nobody else uses that memory meanwhile: this cannot be checked.

use crate::status::Status;
use core::ffi::c_void;

/// Alignment of memory for handles, bytes: that of uint64_t.
pub const SHISEN_ALIGNMENT: usize = 8;

/// Returns SHISEN_ALIGNMENT, the alignment of memory for handles.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_alignment() -> usize {
    SHISEN_ALIGNMENT
}

/// Returns the bytes of memory that a `T` needs, with room to align it.
pub(crate) const fn needed<T>() -> usize {
    size_of::<T>() + align_of::<T>().saturating_sub(SHISEN_ALIGNMENT)
}

/// Returns the place of a `T`, followed by `trailing` bytes, in memory of `size` bytes.
pub(crate) fn room<T>(memory: *mut c_void, size: usize, trailing: usize) -> Result<*mut T, Status> {
    check(memory.cast::<u64>())?;
    match needed::<T>().checked_add(trailing) {
        Some(needed) if needed <= size => {}
        _ => return Err(Status::MemoryTooSmall),
    }
    // A few types need a larger alignment than C's arrays have.
    let past = memory.addr().wrapping_neg() % align_of::<T>();
    Ok(memory.wrapping_byte_add(past).cast())
}

/// # Safety
/// `pointer` is NULL, misaligned, or points to a `T` that nobody changes for as
/// long as the reference lives.
pub(crate) unsafe fn shared<'a, T>(pointer: *const T) -> Result<&'a T, Status> {
    check(pointer)?;
    // SAFETY: not null and aligned; the rest is promised.
    Ok(unsafe { &*pointer })
}

/// # Safety
/// `pointer` is NULL, misaligned, or points to a `T` that nobody else uses for as
/// long as the reference lives.
pub(crate) unsafe fn exclusive<'a, T>(pointer: *mut T) -> Result<&'a mut T, Status> {
    check(pointer)?;
    // SAFETY: not null and aligned; the rest is promised.
    Ok(unsafe { &mut *pointer })
}

/// # Safety
/// `pointer` is NULL, misaligned, or points to memory for a `T`, which need not
/// hold one yet.
pub(crate) unsafe fn write<T>(pointer: *mut T, value: T) -> Result<Status, Status> {
    check(pointer)?;
    // SAFETY: not null and aligned; the rest is promised.
    unsafe { pointer.write(value) };
    Ok(Status::Ok)
}

/// # Safety
/// The same as for [`shared`], for `length` values. A `length` of 0 needs no pointer.
pub(crate) unsafe fn slice<'a, T>(pointer: *const T, length: usize) -> Result<&'a [T], Status> {
    if length == 0 {
        return Ok(&[]);
    }
    check_length(pointer, length)?;
    // SAFETY: not null, aligned and no longer than memory can be; the rest is
    // promised.
    Ok(unsafe { core::slice::from_raw_parts(pointer, length) })
}

/// # Safety
/// The same as for [`exclusive`], for `length` values. A `length` of 0 needs no pointer.
pub(crate) unsafe fn slice_mut<'a, T>(
    pointer: *mut T,
    length: usize,
) -> Result<&'a mut [T], Status> {
    if length == 0 {
        return Ok(&mut []);
    }
    check_length(pointer, length)?;
    // SAFETY: not null, aligned and no longer than memory can be; the rest is
    // promised.
    Ok(unsafe { core::slice::from_raw_parts_mut(pointer, length) })
}

fn check<T>(pointer: *const T) -> Result<(), Status> {
    if pointer.is_null() {
        Err(Status::NullPointer)
    } else if pointer.is_aligned() {
        Ok(())
    } else {
        Err(Status::Misaligned)
    }
}

fn check_length<T>(pointer: *const T, length: usize) -> Result<(), Status> {
    check(pointer)?;
    match length.checked_mul(size_of::<T>()) {
        Some(bytes) if isize::try_from(bytes).is_ok() => Ok(()),
        _ => Err(Status::TooLong),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_there_aligned_and_large_enough() {
        #[repr(align(16))]
        struct Wide {
            _words: [u64; 2],
        }
        let mut memory = [0u64; 4];
        let start = memory.as_mut_ptr().cast::<c_void>();
        let odd = start.wrapping_byte_add(4);
        assert_eq!(room(start, 32, 16), Ok(start.cast::<[u64; 2]>()));
        let wide = room::<Wide>(start, 24, 0).unwrap();
        assert!(wide.is_aligned() && (wide.addr() - start.addr()) <= 8);
        assert_eq!(room::<Wide>(start, 23, 0), Err(Status::MemoryTooSmall));
        for (memory, size, trailing, status) in [
            (core::ptr::null_mut(), 32, 0, Status::NullPointer),
            (odd, 28, 0, Status::Misaligned),
            (start, 15, 0, Status::MemoryTooSmall),
            (start, 32, 17, Status::MemoryTooSmall),
            (start, usize::MAX, usize::MAX, Status::MemoryTooSmall),
        ] {
            assert_eq!(room::<[u64; 2]>(memory, size, trailing), Err(status));
        }
    }

    #[test]
    fn lengths_beyond_all_memory_are_refused() {
        let one = [1u32];
        for length in [usize::MAX, usize::MAX / 4 + 2, usize::MAX / 8 + 1] {
            // SAFETY: refused by its length.
            let slice = unsafe { slice(one.as_ptr(), length) };
            assert_eq!(slice, Err(Status::TooLong), "{length}");
        }
        // SAFETY: one is there.
        assert_eq!(unsafe { slice(one.as_ptr(), 1) }, Ok(&one[..]));
        // SAFETY: none is read.
        assert_eq!(unsafe { slice::<u32>(core::ptr::null(), 0) }, Ok(&[][..]));
    }
}
