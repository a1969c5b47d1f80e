"""Commands in this process: `answer` for those that end well, `refusal` for those that refuse."""

import subprocess
import sys

from typer.testing import CliRunner, Result

from bladewhirl.studies.commands.cli import app


def answer(*words: object) -> Result:
    """Run a command that ends well."""
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == 0, result.output
    return result


def refusal(*words: object) -> str:
    """Return the one line with which a command refuses its input; it prints nothing else."""
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert (result.exit_code, result.stdout) == (2, "")
    [line] = result.stderr.splitlines()
    return line


def loaded(code: str) -> set[str]:
    """Return the names of all modules after code is run in a process of its own."""
    listing = f"import sys\n{code}\nprint(*sys.modules)"
    command = [sys.executable, "-P", "-c", listing]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())
