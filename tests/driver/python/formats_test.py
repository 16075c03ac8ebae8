"""Files of other programs come in, and go out, with their samples and their geometry."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import types

import numpy as np
import pytest

import gicube

z, y, x = np.mgrid[0:6, 0:5, 0:4]
RAMP = (x + 7 * y + 40 * z).astype("i2")  # [z, y, x]; every voxel has a value of its own
COS, SIN = float(np.cos(0.3)), float(np.sin(0.3))
PLACED = gicube.WorldPlacement(gicube.WorldAxes.PATIENT, ((COS, SIN, 0.0), (-SIN, COS, 0.0), (0.0, 0.0, 1.0)),
                               (10.0, 20.0, 30.0))
EDGES = (0.5, 1.0, 2.0)


def to_world(world, spacing):
    matrix = np.eye(4)
    matrix[:3, :3] = (np.array(world.directions) * np.array(spacing)[:, None]).T
    matrix[:3, 3] = world.origin
    return matrix


def expect(volume, spacing=EDGES, samples=RAMP):
    np.testing.assert_array_equal(volume.samples, samples)
    np.testing.assert_allclose(volume.spacing, spacing, rtol=1e-6)


def test_numpy(tmp_path):
    np.save(tmp_path / "c.npy", RAMP)
    np.save(tmp_path / "f.npy", np.asfortranarray(RAMP.T))
    np.savez(tmp_path / "one.npz", v=RAMP)
    np.savez_compressed(tmp_path / "two.npz", a=RAMP, b=RAMP + 1)
    for name in ("c.npy", "f.npy", "one.npz"):
        expect(gicube.read_volume(tmp_path / name), (1, 1, 1))
    expect(gicube.read_volume(tmp_path / "two.npz", part="b"), (1, 1, 1), RAMP + 1)
    with pytest.raises(gicube.FileError, match="part: expected one of the arrays a, b"):
        gicube.read_volume(tmp_path / "two.npz")


def test_hdf5(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("exchange/data", data=RAMP, compression="gzip").attrs["element_size_um"] = EDGES[::-1]
        file["other"] = RAMP.astype("f8")
        file["link"] = h5py.ExternalLink("elsewhere.h5", "/x")
    expect(gicube.read_volume(tmp_path / "a.h5"))
    expect(gicube.read_volume(tmp_path / "a.h5", part="/other"), (1, 1, 1))
    with pytest.raises(gicube.FileError, match="/exchange/data .6 x 5 x 4., /other"):
        gicube.read_volume(tmp_path / "a.h5", part="none")
    with h5py.File(tmp_path / "nexus.nxs", "w") as file:
        file.attrs["default"] = "entry"
        file.create_group("entry").attrs["default"] = "scan"
        file.create_group("entry/scan").attrs["signal"] = "data"
        file["entry/scan/data"] = RAMP.astype("f2")
        file["entry/more"] = RAMP
    expect(gicube.read_volume(tmp_path / "nexus.nxs"), (1, 1, 1))


def test_vtk(tmp_path):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

    image = vtk.vtkImageData()
    image.SetDimensions(*RAMP.shape[::-1])
    image.SetSpacing(EDGES)
    image.SetOrigin(1, 2, 3)
    array = numpy_to_vtk(RAMP.ravel(), deep=1)
    array.SetName("v")
    image.GetPointData().SetScalars(array)
    for mode, packed, base64 in [(0, 0, 0), (1, 0, 0), (1, 1, 0), (2, 0, 0), (2, 0, 1), (2, 1, 0), (2, 1, 1)]:
        writer = vtk.vtkXMLImageDataWriter()
        writer.SetDataMode(mode)
        writer.SetCompressorTypeToZLib() if packed else writer.SetCompressorTypeToNone()
        writer.SetEncodeAppendedData(base64)
        writer.SetFileName(str(tmp_path / "a.vti"))
        writer.SetInputData(image)
        writer.Write()
        volume = gicube.read_volume(tmp_path / "a.vti")
        expect(volume)
        assert tuple(volume.world.origin) == (1, 2, 3)
    for kind in (1, 2):
        writer = vtk.vtkStructuredPointsWriter()
        writer.SetFileType(kind)
        writer.SetFileName(str(tmp_path / "a.vtk"))
        writer.SetInputData(image)
        writer.Write()
        expect(gicube.read_volume(tmp_path / "a.vtk"))
    expect(gicube.volume_from(image))
    gicube.write_volume(tmp_path / "b.vti", RAMP, spacing=EDGES, world=PLACED)
    reader = vtk.vtkXMLImageDataReader()
    reader.SetFileName(str(tmp_path / "b.vti"))
    reader.Update()
    back = reader.GetOutput()
    assert back.GetSpacing() == EDGES and back.GetOrigin() == tuple(PLACED.origin)
    assert back.GetDirectionMatrix().GetElement(0, 1) == pytest.approx(-SIN)
    np.testing.assert_array_equal(vtk_to_numpy(back.GetPointData().GetScalars()), RAMP.ravel())
    gicube.write_volume(tmp_path / "b.mha", RAMP, spacing=EDGES)
    reader = vtk.vtkMetaImageReader()
    reader.SetFileName(str(tmp_path / "b.mha"))
    reader.Update()
    assert reader.GetOutput().GetSpacing() == EDGES
    np.testing.assert_array_equal(vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()), RAMP.ravel())


# OpenVDB's module and the package's library in one process would share variables of OpenVDB.
def run(code, folder):
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, env=os.environ, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_openvdb(tmp_path):
    pytest.importorskip("pyopenvdb")
    np.save(tmp_path / "v.npy", np.ascontiguousarray(RAMP.T.astype("f4")))
    run(
        "import numpy as np, pyopenvdb as vdb\n"
        "g = vdb.FloatGrid(background=-1.0); g.copyFromArray(np.load('v.npy')); g.name = 'density'\n"
        "g.transform = vdb.createLinearTransform(voxelSize=0.5)\n"
        "h = vdb.FloatGrid(); h.fill((1, 1, 1), (3, 3, 3), 2.0); h.name = 'heat'\n"
        "vdb.write('a.vdb', grids=[g, h])",
        tmp_path,
    )
    expect(gicube.read_volume(tmp_path / "a.vdb", part="density"), (0.5, 0.5, 0.5))
    assert gicube.read_volume(tmp_path / "a.vdb", part="heat").dims == (3, 3, 3)
    with pytest.warns(UserWarning, match="density is taken"):
        gicube.read_volume(tmp_path / "a.vdb")
    run("import pyopenvdb as vdb\nvdb.write('set.vdb', grids=[vdb.createLevelSetSphere(radius=4.0)])", tmp_path)
    with pytest.warns(UserWarning, match="a level set; its distances are made positive inside"):
        samples = gicube.read_volume(tmp_path / "set.vdb").samples
    middle = [size // 2 for size in samples.shape]
    assert samples[tuple(middle)] == samples.max() == 3 and samples[0, 0, 0] == samples.min() == -3
    gicube.write_volume(tmp_path / "b.vdb", RAMP, spacing=EDGES, world=PLACED)
    run(
        "import numpy as np, pyopenvdb as vdb\n"
        "v = np.load('v.npy'); g = vdb.read('b.vdb', 'density'); a = np.zeros(v.shape, 'f4'); g.copyToArray(a)\n"
        "assert np.array_equal(a, v)\n"
        f"assert np.allclose(g.transform.indexToWorld((0, 0, 1)), (10, 20, 32))\n"
        f"assert np.allclose(g.transform.indexToWorld((1, 0, 0)), (10 + 0.5 * {COS}, 20 + 0.5 * {SIN}, 30))",
        tmp_path,
    )


def test_nibabel(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    for name in ("a.nii", "a.nii.gz"):
        with pytest.warns(UserWarning, match="17.2 degrees off"):
            gicube.write_volume(tmp_path / name, RAMP, spacing=EDGES, world=PLACED)
            expect(gicube.read_volume(tmp_path / name))
        image = nibabel.load(tmp_path / name)
        np.testing.assert_allclose(image.affine, np.diag([-1, -1, 1, 1]) @ to_world(PLACED, EDGES), atol=1e-6)
        np.testing.assert_array_equal(np.asarray(image.dataobj).T, RAMP)
    stored = nibabel.Nifti1Image(np.ascontiguousarray(RAMP.T[::-1].transpose(2, 0, 1)),
                                 [[0, -1, 0, 3], [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 1]])
    nibabel.save(stored, tmp_path / "turned.nii")
    read, taken = gicube.read_volume(tmp_path / "turned.nii"), gicube.volume_from(stored)
    closest = nibabel.as_closest_canonical(stored)  # right, anterior, superior: ours with x and y the other way
    expect(read, (1, 1, 1), np.asarray(closest.dataobj).T[:, ::-1, ::-1])
    np.testing.assert_array_equal(read.samples, taken.samples)
    np.testing.assert_allclose(to_world(read.world, (1, 1, 1)), to_world(taken.world, (1, 1, 1)))
    assert list(read.world.stored) == list(taken.world.stored)
    nibabel.save(nibabel.Nifti1Pair(RAMP.T, np.eye(4)), tmp_path / "pair.img")
    nibabel.save(nibabel.AnalyzeImage(RAMP.T, np.eye(4)), tmp_path / "analyze.img")
    assert gicube.read_volume(tmp_path / "pair.img").samples.sum() == RAMP.sum()
    expect(gicube.read_volume(tmp_path / "analyze.img"), (1, 1, 1))


def dicom_slice(pydicom, position, samples, **fields):
    from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, generate_uid

    meta = pydicom.dataset.FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = CTImageStorage, generate_uid()
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    data = pydicom.dataset.FileDataset("", {}, file_meta=meta, preamble=b"\0" * 128)
    data.is_little_endian, data.is_implicit_VR = True, False
    data.SOPClassUID, data.SOPInstanceUID, data.Modality = CTImageStorage, meta.MediaStorageSOPInstanceUID, "CT"
    data.Rows, data.Columns = samples.shape
    data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
    data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 16, 12, 11, 0
    data.PixelSpacing, data.ImageOrientationPatient = [1.0, 0.5], [1, 0, 0, 0, 1, 0]
    data.ImagePositionPatient = list(position)
    data.RescaleIntercept, data.RescaleSlope, data.SeriesInstanceUID = -1024, 1, "1.2.3"
    data.PixelData = samples.astype("<u2").tobytes()
    for name, value in fields.items():
        setattr(data, name, value)
    return data


def save_series(pydicom, folder, shift=(0, 0, 2.0), order=range(6), **fields):
    folder.mkdir(exist_ok=True)
    for number, slice_ in enumerate(order):
        position = [slice_ * part for part in shift]
        data = dicom_slice(pydicom, position, RAMP[slice_], InstanceNumber=number + 1, **fields)
        data.save_as(folder / f"any name {number}{fields.get('SeriesNumber', '')}", write_like_original=False)


def test_dicom(tmp_path):
    pydicom = pytest.importorskip("pydicom")
    save_series(pydicom, tmp_path / "a", order=[3, 0, 5, 1, 4, 2])
    volume = gicube.read_volume(tmp_path / "a")
    expect(volume, samples=RAMP - 1024)
    assert volume.world.axes is gicube.WorldAxes.PATIENT and volume.samples.dtype == "int16"
    save_series(pydicom, tmp_path / "gap", order=[0, 1, 2, 4, 5])
    with pytest.warns(UserWarning, match="even steps of 2, got 1 others, the first of 4 behind slice 3"):
        assert gicube.read_volume(tmp_path / "gap").dims == (4, 5, 5)
    save_series(pydicom, tmp_path / "tilt", shift=(0, 0.5, 2.0))
    with pytest.warns(UserWarning, match="gantry tilt: expected .* got 14.0 degrees"):
        gicube.read_volume(tmp_path / "tilt")
    save_series(pydicom, tmp_path / "two", SeriesNumber=7, SeriesDescription="thorax")
    save_series(pydicom, tmp_path / "two", order=[0, 1], SeriesNumber=8, SeriesDescription="scout",
                SeriesInstanceUID="1.2.4")
    with pytest.warns(UserWarning,
                      match="1 .CT thorax, 6 of 4 x 5., 2 .CT scout, 2 of 4 x 5., got none; the one of most slices, 1"):
        expect(gicube.read_volume(tmp_path / "two"), samples=RAMP - 1024)
    assert gicube.read_volume(tmp_path / "two", part="scout").dims == (4, 5, 2)
    with pytest.raises(gicube.FileError, match="part: expected one series: 1 .CT thorax"):
        gicube.read_volume(tmp_path / "two", part="9")


def test_dicom_of_several_frames_and_packed_by_rle(tmp_path):
    pydicom = pytest.importorskip("pydicom")
    data = dicom_slice(pydicom, (0, 0, 0), RAMP[0], NumberOfFrames=6, SpacingBetweenSlices=2.0)
    data.PixelData = RAMP.astype("<u2").tobytes()
    del data.ImagePositionPatient
    data.save_as(tmp_path / "frames.dcm", write_like_original=False)
    with pytest.warns(UserWarning, match="ImagePositionPatient: expected a position of each slice"):
        expect(gicube.read_volume(tmp_path / "frames.dcm"), samples=RAMP - 1024)
    (tmp_path / "rle").mkdir()
    for number in range(6):
        data = dicom_slice(pydicom, (0, 0, 2.0 * number), RAMP[number])
        data.compress(pydicom.uid.RLELossless)
        data.save_as(tmp_path / "rle" / str(number), write_like_original=False)
    expect(gicube.read_volume(tmp_path / "rle"), samples=RAMP - 1024)


def test_frames_of_a_dicom_file_without_places_of_their_own_follow_each_other(tmp_path):
    pydicom = pytest.importorskip("pydicom")
    data = dicom_slice(pydicom, (1, 2, 3), RAMP[0], NumberOfFrames=6, SpacingBetweenSlices=2.0)
    data.PixelData = RAMP.astype("<u2").tobytes()
    data.save_as(tmp_path / "frames.dcm", write_like_original=False)
    volume = gicube.read_volume(tmp_path / "frames.dcm")
    expect(volume, samples=RAMP - 1024)
    assert volume.world.axes is gicube.WorldAxes.PATIENT and tuple(volume.world.origin) == (1, 2, 3)


def test_dicom_slices_with_more_bits_than_the_first_keep_their_values(tmp_path):
    pydicom = pytest.importorskip("pydicom")
    for number in range(6):
        wide = {"BitsStored": 16, "HighBit": 15} if number == 5 else {}
        data = dicom_slice(pydicom, (0, 0, 2.0 * number), RAMP[number] + (60000 if wide else 0), **wide)
        data.save_as(tmp_path / str(number), write_like_original=False)
    expected = RAMP.astype("f4") - 1024
    expected[5] += 60000
    expect(gicube.read_volume(tmp_path), samples=expected)


# Lossless JPEG and JPEG-LS.
@pytest.mark.parametrize("program, option", [("dcmcjpeg", "+e1"), ("dcmcjpeg", "+el"), ("dcmcjpls", "+el")])
def test_dicom_packed_by_jpeg(tmp_path, program, option):
    pydicom = pytest.importorskip("pydicom")
    if not shutil.which(program):
        pytest.skip(f"no {program}: Debian package dcmtk")
    save_series(pydicom, tmp_path / "plain")
    (tmp_path / "packed").mkdir()
    for file in (tmp_path / "plain").iterdir():
        subprocess.run([program, option, file, tmp_path / "packed" / file.name], check=True)
    syntax = {pydicom.dcmread(file).file_meta.TransferSyntaxUID.name for file in (tmp_path / "packed").iterdir()}
    assert len(syntax) == 1 and "JPEG" in syntax.pop()
    expect(gicube.read_volume(tmp_path / "packed"), samples=RAMP - 1024)


def test_an_image_with_simpleitks_methods_is_taken_with_its_geometry(monkeypatch):
    """A stand-in where the package is absent, as in Debian 12: its module, type and methods by its documentation."""
    package = types.ModuleType("SimpleITK")

    class Image:
        __module__ = "SimpleITK.SimpleITK"

        def GetPixelIDTypeAsString(self):
            return "16-bit signed integer"

        def GetDimension(self):
            return 3

        def GetSpacing(self):
            return EDGES

        def GetOrigin(self):
            return PLACED.origin

        def GetDirection(self):  # row by row; the columns are the directions of x, y, z
            return tuple(np.array(PLACED.directions).T.ravel())

    package.GetArrayFromImage = lambda image: RAMP  # [z, y, x]
    monkeypatch.setitem(sys.modules, "SimpleITK", package)
    volume = gicube.volume_from(Image())
    expect(volume)
    np.testing.assert_allclose(to_world(volume.world, EDGES), to_world(PLACED, EDGES), atol=1e-9)
    Image.GetDimension = lambda self: 2
    with pytest.raises(gicube.BadArgument, match="image: expected three axes, got 2"):
        gicube.volume_from(Image())


def test_tiff_of_imagej_and_of_every_type(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    for kind in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f2", "f4", "f8"):
        tifffile.imwrite(tmp_path / "t.tif", RAMP.clip(0, 127).astype(kind), photometric="minisblack")
        expect(gicube.read_volume(tmp_path / "t.tif"), (1, 1, 1), RAMP.clip(0, 127))
    samples = RAMP.astype("u2")
    tifffile.imwrite(tmp_path / "z.tif", samples, imagej=True, resolution=(2, 1),
                     metadata={"spacing": 2.0, "unit": "um", "axes": "ZYX"})
    expect(gicube.read_volume(tmp_path / "z.tif"))
    for axes, axis in (("ZCYX", 1), ("TZYX", 0)):
        tifffile.imwrite(tmp_path / "h.tif", np.stack([samples, samples + 300], axis), imagej=True,
                         metadata={"axes": axes})
        with pytest.warns(UserWarning, match="expected a part, 1..2, got none; 1 is taken"):
            expect(gicube.read_volume(tmp_path / "h.tif"), (1, 1, 1))
        expect(gicube.read_volume(tmp_path / "h.tif", part="2"), (1, 1, 1), samples + 300)
    text = "ImageJ=1.53t\nimages=6\nslices=6\nunit=um\nspacing=2.0\n"
    with tifffile.TiffWriter(tmp_path / "one.tif", byteorder=">") as writer:
        writer.write(samples[0], photometric="minisblack", description=text, metadata=None, resolution=(2, 1))
    with tifffile.TiffFile(tmp_path / "one.tif") as file:
        begin = file.pages[0].dataoffsets[0]
    one = (tmp_path / "one.tif").read_bytes()
    (tmp_path / "one.tif").write_bytes(one[:begin] + samples.astype(">u2").tobytes())
    expect(gicube.read_volume(tmp_path / "one.tif"))


# Types that OpenImageIO refuses, or misreads: a TIFF of single bits need not say how many bits its samples have.
@pytest.mark.parametrize("options", [{}, {"tile": (16, 16)}, {"compression": "zlib"}, {"byteorder": ">"}])
def test_tiff_of_large_integers_complex_numbers_and_single_bits(tmp_path, options):
    tifffile = pytest.importorskip("tifffile")

    def read(samples, photometric="minisblack"):
        tifffile.imwrite(tmp_path / "t.tif", samples, photometric=photometric, **options)
        return gicube.read_volume(tmp_path / "t.tif").samples

    wide = np.pad(RAMP.astype("i8"), ((0, 0), (0, 20), (0, 30)))  # several tiles
    for factor in (2**40, -(2**40)):
        np.testing.assert_array_equal(read(wide * factor), (wide * factor).astype("f4"))
    np.testing.assert_array_equal(read(wide.astype("u8") << 52), (wide.astype("u8") << 52).astype("f4"))
    for kind in ("c8", "c16"):
        np.testing.assert_array_equal(read(wide.astype(kind) * (3 - 4j)), 5 * wide)
    if "compression" in options:
        return  # tifffile does not pack single bits so
    mask = wide % 3 == 1
    np.testing.assert_array_equal(read(mask), 255 * mask)
    np.testing.assert_array_equal(read(mask, "miniswhite"), 255 * ~mask)


def test_helpers_take_images_with_their_geometry():
    nibabel = pytest.importorskip("nibabel")
    image = nibabel.Nifti1Image(np.asfortranarray(RAMP.T), np.diag([-0.5, 1.0, 2.0, 1.0]))
    volume = gicube.volume_from(image)
    assert volume.spacing == EDGES and list(volume.world.stored) == [1, -2, 3]
    assert gicube.fit_view(image) == gicube.fit_view(volume) != gicube.fit_view(np.asarray(volume.samples))
    np.testing.assert_array_equal(gicube.coarser(image, 1).samples, gicube.coarser(volume, 1).samples)


def test_what_is_no_image_is_named():
    with pytest.raises(gicube.BadArgument,
                       match="image: expected an image of SimpleITK, nibabel, VTK or PyVista, got int"):
        gicube.volume_from(3)


def test_named_views_are_those_of_the_patient():
    patient = gicube.WorldPlacement(gicube.WorldAxes.PATIENT)
    volume = gicube.Volume(RAMP, world=patient)
    view = gicube.fit_view(volume, name="anterior")
    assert view.eye[1] < 0 and view.eye[0] == view.look_at[0]
    with pytest.raises(gicube.InputError, match="view: expected one of front"):
        gicube.fit_view(gicube.Volume(RAMP), name="anterior")


def test_samples_that_are_no_numbers_name_the_file_and_what_can_be_done(tmp_path):
    samples = RAMP.astype("f4")
    samples[1, 2, 3] = np.nan
    np.save(tmp_path / "holes.npy", samples)
    program = pathlib.Path(os.environ["GICUBE_BOARD"]).parent / "gicube-render"
    command = [program, tmp_path / "holes.npy", "--size", "8x8", "-o", tmp_path / "o.png"]
    refused = subprocess.run(command, capture_output=True, text=True)
    assert refused.returncode == 1
    assert re.search(r"holes\.npy: samples at voxel \(3, 2, 1\): expected a finite number, .*--nan VALUE.*got nan",
                     refused.stderr), refused.stderr
    assert subprocess.run([*command, "--nan", "0"]).returncode == 0
