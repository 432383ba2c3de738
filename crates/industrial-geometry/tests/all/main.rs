//! The examples, run as tests: each checks what it prints.

type Outcome = Result<(), Box<dyn std::error::Error>>;

#[path = "../../examples/fit_curve.rs"]
mod fit_curve;
#[path = "../../examples/fit_surface.rs"]
mod fit_surface;
#[path = "../../examples/inspect.rs"]
mod inspect;
#[path = "../../examples/parameterize.rs"]
mod parameterize;
#[path = "../../examples/project.rs"]
mod project;
#[path = "../../examples/read_write.rs"]
mod read_write;
#[path = "../../examples/register_with_lock.rs"]
mod register_with_lock;
#[path = "../../examples/views.rs"]
mod views;

#[test]
fn fit_curve_example() -> Outcome {
    Ok(fit_curve::main()?)
}

#[test]
fn fit_surface_example() -> Outcome {
    Ok(fit_surface::main()?)
}

#[test]
fn inspect_example() -> Outcome {
    inspect::main()
}

#[test]
fn parameterize_example() -> Outcome {
    Ok(parameterize::main()?)
}

#[test]
fn project_example() -> Outcome {
    Ok(project::main()?)
}

#[test]
fn read_write_example() -> Outcome {
    read_write::main()
}

#[test]
fn register_with_lock_example() -> Outcome {
    register_with_lock::main()
}

#[test]
fn views_example() -> Outcome {
    views::main()
}
