# Thin: run.py owns .venv, .ci/run owns the checks. The command after "lock:" is the one in CONTRIBUTING.md.
BIN := .venv/bin

.PHONY: setup test lint lock coverage

setup:
	python3 run.py setup

test: setup
	python3 run.py test

lint: setup
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

# Branches of what stands between a law and an arm.
coverage: setup
	$(BIN)/coverage run --branch --source=src/burnish/runtime -m pytest tests/runtime tests/hardware/test_torque_mode_session.py
	$(BIN)/coverage report -m --fail-under=100

lock:
	$(BIN)/uv pip compile --no-config --universal --python-version 3.10 --generate-hashes --no-strip-extras \
		--no-header --upgrade --quiet --extra dev --output-file requirements.lock.txt pyproject.toml
