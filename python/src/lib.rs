use pyo3::prelude::*; #[pymodule] fn _core(m:&Bound<PyModule>)->PyResult<()>{ let _=m; Ok(()) }
