"""Pictures as arrays, and their differences."""
import ctypes

import numpy as np

from studies.table import FileError

CHANNELS = 4
_powf = ctypes.CDLL("libm.so.6").powf  # numpy's powers of floats differ between processors
_powf.argtypes, _powf.restype = [ctypes.c_float] * 2, ctypes.c_float
_power = np.frompyfunc(_powf, 2, 1)


def read_picture(file):
    """Pixels of an EXR of gicube-render (linear light): display-referred red, green, blue, premultiplied, and alpha,
    0..1, as float32 [row, column, 4] from the top; the sRGB curve (IEC 61966-2-1) is applied again. Raises
    FileError."""
    import OpenImageIO as oiio  # slow, and not needed for errors by figures

    opened = oiio.ImageInput.open(str(file))
    if opened is None:
        raise FileError(f"{file}: picture: expected an image that can be read, got {oiio.geterror()}")
    channels = opened.spec().nchannels
    if channels != CHANNELS:
        raise FileError(f"{file}: channels: expected red, green, blue and alpha, got {channels}")
    picture = opened.read_image(oiio.FLOAT)
    if picture is None:
        raise FileError(f"{file}: picture: expected whole pixels, got {opened.geterror()}")
    alpha = picture[..., 3:]
    with np.errstate(divide="ignore", invalid="ignore"):
        linear = picture[..., :3] / alpha
        curve = np.where(linear <= np.float32(0.0031308), np.float32(12.92) * linear,
                         np.float32(1.055) * _power(linear,
                                                    np.float32(1) / np.float32(2.4)).astype(np.float32) - np.float32(
                                                        0.055))
        picture[..., :3] = np.where(alpha > 0, alpha * curve, picture[..., :3])
    return picture


def _between(count, of):
    """Position of each of `count` pixels among `of`: two pixels, and the share of the second."""
    at = np.clip((np.arange(count) + 0.5) * of / count - 0.5, 0, of - 1.0)
    first = at.astype(int)
    return first, np.minimum(first + 1, of - 1), (at - first).astype(np.float32)


def resized(picture, width, height):
    """Resizes with bilinear interpolation between pixel centres."""
    first, second, share = _between(width, picture.shape[1])
    share = share[None, :, None]
    rows = picture[:, first] * (1 - share) + picture[:, second] * share
    first, second, share = _between(height, picture.shape[0])
    share = share[:, None, None]
    return rows[first] * (1 - share) + rows[second] * share


def rmse(picture, reference):
    """Root mean square difference over all four channels of all pixels, peak 1. A picture of another size is first
    resized to the reference's."""
    height, width = reference.shape[:2]
    if picture.shape != reference.shape:
        picture = resized(picture, width, height)
    off = picture.astype(np.float64).ravel() - reference.astype(np.float64).ravel()
    return float(np.sqrt(np.cumsum(off * off)[-1] / off.size))  # summed in order: the same bits everywhere
