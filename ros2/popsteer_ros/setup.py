"""The colcon package; popsteer itself is a wheel, with the extra ``ros2``."""

from setuptools import setup

NAME = "popsteer_ros"

setup(
    name=NAME,
    version="0.3.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/track.launch.py"]),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    entry_points={"console_scripts": [f"track = {NAME}.node:main"]},
)
